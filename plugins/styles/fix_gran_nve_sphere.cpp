// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_nve_sphere.h"

#include "../kernels/touching_pairs.h"
#include "error.h"
#include "motion.h"

using namespace LAMMPS_NS;
using namespace granwave;

constexpr double INERTIA = 0.4;    // moment of inertia of a sphere / (m R^2)

FixGranNVESphere::FixGranNVESphere(LAMMPS *lmp, int narg, char **arg) : FixGranNVE(lmp, narg, arg)
{
  if (!atom->radius_flag || !atom->rmass_flag || !atom->omega_flag || !atom->torque_flag)
    error->all(FLERR, "Fix {} requires atom attributes radius, rmass, omega and torque (atom_style sphere)", STYLE);
}

void FixGranNVESphere::init()
{
  FixGranNVE::init();
  require_radii();
}

/* Stop with an error if an atom is a point, which has no moment of inertia. */
void FixGranNVESphere::require_radii() const
{
  for (int i = 0; i < atom->nlocal; i++)
    if ((atom->mask[i] & groupbit) && atom->radius[i] == 0.0)
      error->one(FLERR, "Fix {} {}: atom {} has the radius 0 and cannot rotate; integrate it with fix gran/nve", STYLE, id,
                 atom->tag[i]);
}

/* Make a half kick of the angular velocities. */
void FixGranNVESphere::turn() const
{
  double *const *const omega = atom->omega, *const *const torque = atom->torque;
  const double *const radius = atom->radius, *const rmass = atom->rmass;
  const double half_step = dtf / INERTIA;
  for (int begin = 0; begin < atom->nlocal; begin += RestingBlocks::SIZE) {
    const int end = std::min(begin + RestingBlocks::SIZE, atom->nlocal);
    if (all_zero(torque[begin], 3 * (end - begin))) continue;
    for (int i = begin; i < end; i++) {
      if (!(atom->mask[i] & groupbit)) continue;
      const double kick = half_step / (radius[i] * radius[i] * rmass[i]);
      for (int d = 0; d < 3; d++) omega[i][d] += kick * torque[i][d];
    }
  }
}

void FixGranNVESphere::initial_integrate(int step)
{
  FixGranNVE::initial_integrate(step);
  turn();
}

void FixGranNVESphere::final_integrate()
{
  FixGranNVE::final_integrate();
  turn();
}
