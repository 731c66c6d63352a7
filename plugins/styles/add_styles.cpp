// SPDX-License-Identifier: GPL-2.0-only
/* Registration of the styles with LAMMPS, for the loader (granwaveplugin.cpp). This file contains everything that depends
   on internals of LAMMPS: the tables of virtual functions of its classes, which are compared first, and its maps of
   styles. */

#include "all_styles.h"
#include "force.h"
#include "input.h"
#include "lammps.h"
#include "modify.h"

#include <dlfcn.h>
#include <elf.h>
#include <link.h>

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <typeinfo>

using namespace LAMMPS_NS;

namespace {

const char here = 0;    // an address in this library

/* ---------------------------------------------------------------------- comparison of classes */

/* Table of the virtual functions of a class in a loaded library; without entries if the library does not export it, or its size. */
struct VirtualTable {
  void *const *entries = nullptr;
  std::size_t size = 0;

  VirtualTable(void *library, const std::type_info &type)
  {
    Dl_info info;
    void *symbol = nullptr;
    void *const address = dlsym(library, (std::string("_ZTV") + type.name()).c_str());
    if (!address || !dladdr1(address, &info, &symbol, RTLD_DL_SYMENT) || !symbol) return;
    entries = static_cast<void *const *>(address);
    size = static_cast<const ElfW(Sym) *>(symbol)->st_size / sizeof(void *);
  }
};

/* Return the address of the library that has a function; null if none has. */
void *library_of(void *function)
{
  Dl_info info;
  return function && dladdr(function, &info) ? info.dli_fbase : nullptr;
}

/* Return how a class of LAMMPS differs from what a style was compiled with, which adds no virtual function to it; empty if it does not.
   What was not found counts as different: so do a table without size, another number of functions, and functions of LAMMPS that are in
   another order. */
template <class Base, class Style> std::string class_difference(void *styles, const char *name)
{
  constexpr std::size_t FIRST = 2;    // two entries before the functions: offset and type
  const VirtualTable expected(styles, typeid(Style)), found(RTLD_DEFAULT, typeid(Base));
  const std::string of_class = std::string("class ") + name;
  if (expected.size == 0) return of_class + ", of which the plugin does not show its table of virtual functions";
  if (found.size == 0) return of_class + ", of which this library does not show the table of virtual functions";
  if (expected.size != found.size)
    return of_class + " with " + std::to_string(found.size - FIRST) + " virtual functions, expected " +
           std::to_string(expected.size - FIRST);
  for (std::size_t n = FIRST; n < found.size; n++) {
    void *const inherited = expected.entries[n], *const own = found.entries[n];
    const bool both = library_of(own) && library_of(inherited) == library_of(own);
    if (both && inherited != own) return of_class + " with another order of its virtual functions";
  }
  return {};
}

/* Return how the classes of LAMMPS differ from those that the styles were compiled with; empty if they do not. */
std::string difference()
{
  Dl_info info;
  void *const styles = dladdr(&here, &info) ? dlopen(info.dli_fname, RTLD_LAZY | RTLD_NOLOAD) : nullptr;
  if (!styles) return "no name of the plugin's own library";
  std::string found = class_difference<Pair, PairGranHysteretic>(styles, "Pair");
  if (found.empty()) found = class_difference<Fix, FixGranHystereticHistory>(styles, "Fix");
  if (found.empty()) found = class_difference<Compute, ComputeGranHystereticLocal>(styles, "Compute");
  dlclose(styles);
  return found;
}

/* ---------------------------------------------------------------------- registration */

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

/* Register all styles. Returns how the library differs from that of the build, in which case nothing is registered, or null. */
extern "C" __attribute__((visibility("default"))) const char *granwave_add_styles(void *instance, void *handle,
                                                                                  void *regfunc)
{
  static const std::string differs = difference();
  if (!differs.empty()) return differs.c_str();
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
  return nullptr;
}
