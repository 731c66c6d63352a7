// SPDX-License-Identifier: GPL-2.0-only
/* The two styles of this branch as a plugin, to try and test them with a LAMMPS that does not have them. Not part of the branch. */

#include "compute_pair_dissipation_local.h"
#include "fix_pair_dissipation.h"
#include "lammps.h"

using namespace LAMMPS_NS;

namespace {

/* The plugin loader's public interface (LAMMPS manual, "Writing plugins"). */
struct Registration {
  const char *version, *style, *name, *info, *author;
  void *creator;
  void *handle;
};
using Register = void (*)(Registration *, void *);

Compute *create_compute(LAMMPS *lmp, int narg, char **arg) { return new ComputePairDissipationLocal(lmp, narg, arg); }

Fix *create_fix(LAMMPS *lmp, int narg, char **arg) { return new FixPairDissipation(lmp, narg, arg); }

}    // namespace

extern "C" __attribute__((visibility("default"))) void lammpsplugin_init(void *lmp, void *handle, void *regfunc)
{
  const char *version = static_cast<LAMMPS *>(lmp)->version;
  const char *info = "energy dissipated by granular contacts";
  Registration compute{
      version, "compute", "pair/dissipation/local", info, "granwave", reinterpret_cast<void *>(&create_compute), handle};
  Registration fix{version, "fix", "PAIR_DISSIPATION", info, "granwave", reinterpret_cast<void *>(&create_fix), handle};
  const auto add = reinterpret_cast<Register>(regfunc);
  add(&compute, lmp);
  add(&fix, lmp);
}
