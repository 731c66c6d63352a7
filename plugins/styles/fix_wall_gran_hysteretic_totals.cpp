// SPDX-License-Identifier: GPL-2.0-only
/* Fix wall/gran/hysteretic: energies and counts of all spheres, and the values of the global scalar and vector. */

#include "fix_wall_gran_hysteretic.h"

#include "atom.h"
#include "update.h"

#include <cmath>

using namespace LAMMPS_NS;
using granwave::ScaledLaw;

void FixWallGranHysteretic::tally()
{
  if (tallied == update->ntimestep) return;
  tallied = update->ntimestep;
  double mine[N_TOTALS] = {};
  for (int i = 0; i < atom->nlocal; i++) {
    const double *state = array_atom[i];
    if (state[PEAK_OVERLAP] == 0.0) continue;
    const ScaledLaw &scaled = scaled_law(i);
    mine[DISSIPATED_SUM] += state[DISSIPATED];
    mine[FRICTION_LOSS_SUM] += state[FRICTION_LOSS];
    mine[VISCOUS_SUM] += state[VISCOUS];
    if (law.entry().yields() && state[TIME_YIELD] >= 0.0) mine[YIELDED] += 1.0;
    if (state[PEAK_OVERLAP] > scaled.valid_overlap()) mine[BEYOND_LAW] += 1.0;
    for (int side = 0; side < 2; side++) {
      const Side &own = sides[2 * i + side];
      const double overlap = depth(i, side);
      if (friction > 0.0) mine[TANGENTIAL_STORED] += granwave::tangential_energy(springs[2 * i + side]);
      if (own.touching == 0.0 || overlap <= 0.0) continue;
      mine[STORED] += scaled.elastic_energy(overlap, law_history(i, side));
    }
  }
  MPI_Allreduce(mine, totals, N_TOTALS, MPI_DOUBLE, MPI_SUM, world);
}

void FixWallGranHysteretic::add_magnitudes(int i, double sums[3]) const
{
  const double force = array_atom[i][FORCE];
  if (force <= 0.0) return;
  double normal[3];
  inward(i, 1, normal);
  for (int d = 0; d < 3; d++) {
    double along = 0.0;
    for (int side = 0; side < 2 && friction > 0.0; side++) along += springs[2 * i + side].force[d];
    sums[d] += std::fabs(force * normal[d]) + std::fabs(along);
  }
}

double FixWallGranHysteretic::compute_scalar()
{
  tally();
  return totals[STORED];
}

double FixWallGranHysteretic::compute_vector(int n)
{
  if (n < 3) {
    double sum = 0.0;
    MPI_Allreduce(&wall_force[n], &sum, 1, MPI_DOUBLE, MPI_SUM, world);
    return sum;
  }
  constexpr int AT_SUPPORT = 3 + VISCOUS_SUM;    // first value of the support; the viscous loss comes after all others
  if (n < AT_SUPPORT || n == AT_SUPPORT + 6) {
    tally();
    return totals[n < AT_SUPPORT ? n - 3 : int(VISCOUS_SUM)];
  }
  if (!support) return 0.0;
  switch (n - AT_SUPPORT) {
    case 0:
      return support->displacement();
    case 1:
      return support->velocity();
    case 2:
      return support->energy();
    case 3:
      return support->damped();
    case 4:
      return support->force_on_ground();
    default:
      return support->work();
  }
}
