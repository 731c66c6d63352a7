// SPDX-License-Identifier: GPL-2.0-only
/* Registration of the styles with LAMMPS, after granwaveplugin.cpp has checked that library and styles match. */

#include "all_styles.h"
#include "force.h"
#include "input.h"
#include "lammps.h"
#include "modify.h"

#include <set>
#include <string>
#include <string_view>

using namespace LAMMPS_NS;

namespace {

/* The plugin loader's public interface (LAMMPS manual, "Writing plugins"). */
struct Registration {
  const char *version, *style, *name, *info, *author;
  void *creator;
  void *handle;
};
using Register = void (*)(Registration *, void *);
std::set<std::string> infos;    // LAMMPS stores pointers to them

template <class Base, class Style> Base *create(LAMMPS *lmp) { return new Style(lmp); }
template <class Base, class Style> Base *create_named(LAMMPS *lmp, int narg, char **arg)
{
  return new Style(lmp, narg, arg);
}

}    // namespace

extern "C" __attribute__((visibility("default"))) void granwave_add_styles(void *instance, void *handle, void *regfunc)
{
  auto *lmp = static_cast<LAMMPS *>(instance);
  // releases before 2025 register a plugin once per process: add the style to the map of a second instance
  const auto add = [&](const char *style, const char *name, auto *creator, auto &known) {
    const auto info = infos.insert(std::string("granwave ") + GRANWAVE_VERSION + ": " + style + " style " + name).first;
    Registration entry{lmp->version, style, name, info->c_str(), "granwave", reinterpret_cast<void *>(creator), handle};
    reinterpret_cast<Register>(regfunc)(&entry, lmp);
    known.emplace(name, creator);
  };
  auto &pairs = *lmp->force->pair_map;
  auto &fixes = *lmp->modify->fix_map;
  auto &computes = *lmp->modify->compute_map;
  // the blocks of the headers, from which LAMMPS registers the styles where they are built in
#define CHECK(name, Class) static_assert(std::string_view(#name) == Class::STYLE)
#define PAIR_CLASS
#define PairStyle(name, Class)                                                                                              \
  CHECK(name, Class);                                                                                                       \
  add("pair", #name, &create<Pair, Class>, pairs)
#define FIX_CLASS
#define FixStyle(name, Class)                                                                                               \
  CHECK(name, Class);                                                                                                       \
  add("fix", #name, &create_named<Fix, Class>, fixes)
#define COMPUTE_CLASS
#define ComputeStyle(name, Class)                                                                                           \
  CHECK(name, Class);                                                                                                       \
  add("compute", #name, &create_named<Compute, Class>, computes)
  // `clear` keeps commands, and the loader, which registers all styles again, would warn of a duplicate
#define COMMAND_CLASS
#define CommandStyle(name, Class)                                                                                           \
  CHECK(name, Class);                                                                                                       \
  lmp->input->command_map->emplace(#name, &create<Command, Class>)
#include "all_styles.h"
}
