// SPDX-License-Identifier: GPL-2.0-only
/* Registration of the styles with LAMMPS, after granwaveplugin.cpp has checked that library and styles match. */

#include "compute_gran_hysteretic.h"
#include "fix_gran_cylinder.h"
#include "fix_gran_damping.h"
#include "fix_gran_hysteretic_history.h"
#include "fix_gran_load.h"
#include "fix_gran_timestep.h"
#include "fix_wall_gran_hysteretic.h"
#include "force.h"
#include "gran_dents.h"
#include "input.h"
#include "lammps.h"
#include "modify.h"
#include "pair_gran_hysteretic.h"

#include <set>
#include <string>

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
  add("pair", PairGranHysteretic::STYLE, &create<Pair, PairGranHysteretic>, pairs);
  add("fix", FixGranHystereticHistory::STYLE, &create_named<Fix, FixGranHystereticHistory>, fixes);
  add("fix", FixWallGranHysteretic::STYLE, &create_named<Fix, FixWallGranHysteretic>, fixes);
  add("fix", FixGranAbsorb::STYLE, &create_named<Fix, FixGranAbsorb>, fixes);
  add("fix", FixGranCylinder::STYLE, &create_named<Fix, FixGranCylinder>, fixes);
  add("fix", FixGranHolder::STYLE, &create_named<Fix, FixGranHolder>, fixes);
  add("fix", FixGranLoad::STYLE, &create_named<Fix, FixGranLoad>, fixes);
  add("fix", FixGranTimestep::STYLE, &create_named<Fix, FixGranTimestep>, fixes);
  add("compute", ComputeGranHystereticAtom::STYLE, &create_named<Compute, ComputeGranHystereticAtom>, computes);
  add("compute", ComputeGranHystereticLocal::STYLE, &create_named<Compute, ComputeGranHystereticLocal>, computes);
  add("compute", ComputeGranHystereticContact::STYLE, &create_named<Compute, ComputeGranHystereticContact>, computes);
  add("compute", ComputeGranHystereticEnergy::STYLE, &create_named<Compute, ComputeGranHystereticEnergy>, computes);
  add("compute", ComputeGranHystereticSums::STYLE, &create_named<Compute, ComputeGranHystereticSums>, computes);
  // `clear` keeps commands, and the loader, which registers all styles again, would warn of a duplicate
  lmp->input->command_map->emplace(GranDents::STYLE, &create<Command, GranDents>);
}
