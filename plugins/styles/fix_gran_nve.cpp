// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_nve.h"

#include "../kernels/touching_pairs.h"
#include "error.h"
#include "force.h"
#include "motion.h"

using namespace LAMMPS_NS;
using namespace granwave;

FixGranNVE::FixGranNVE(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg != 3) error->all(FLERR, "Illegal fix {}: it takes no words, found '{}'", style, arg[3]);
  dynamic_group_allow = 1;
  time_integrate = 1;
}

void FixGranNVE::init()
{
  refuse_respa(lmp, fmt::format("Fix {}", style));
  reset_dt();
}

void FixGranNVE::reset_dt()
{
  dtv = update->dt;
  dtf = 0.5 * update->dt * force->ftm2v;
}

/* Make a half kick, and move the atoms at the start of a step. */
template <bool MOVES> void FixGranNVE::integrate()
{
  double *const *const x = atom->x, *const *const v = atom->v, *const *const f = atom->f;
  for (int begin = 0; begin < atom->nlocal; begin += RestingBlocks::SIZE) {
    const int end = std::min(begin + RestingBlocks::SIZE, atom->nlocal), n = 3 * (end - begin);
    if (all_zero(f[begin], n) && (!MOVES || all_zero(v[begin], n))) continue;
    for (int i = begin; i < end; i++) {
      if (!(atom->mask[i] & groupbit)) continue;
      const double kick = dtf / mass_of(atom, i);
      for (int d = 0; d < 3; d++) {
        v[i][d] += kick * f[i][d];
        if (MOVES) x[i][d] += dtv * v[i][d];
      }
    }
  }
}

void FixGranNVE::initial_integrate(int) { integrate<true>(); }

void FixGranNVE::final_integrate() { integrate<false>(); }
