// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: pairs across a periodic boundary.

   Such a pair is computed for each of its spheres i and j, once with j and a ghost of i, and once with i and a ghost of j, from the
   same numbers (periodic_images.h). */

#include "pair_gran_hysteretic.h"

#include "../laws/periodic_images.h"
#include "comm.h"
#include "domain.h"

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

using Vector = std::array<double, 3>;

Vector plain_difference(const double *of_i, const double *of_j)
{
  return {of_i[0] - of_j[0], of_i[1] - of_j[1], of_i[2] - of_j[2]};
}

}    // namespace

/* Vector from sphere j to sphere i. */
PairGranHysteretic::Vector PairGranHysteretic::vector_between(int i, int j) const
{
  const double *const xi = atom->x[i], *const xj = atom->x[j];
  const bool ghost_is_j = images(i).none();
  const auto &of_ghost = images(ghost_is_j ? j : i);
  if (of_ghost.none()) return plain_difference(xi, xj);
  const double edges[6] = {domain->xprd, domain->yprd, domain->zprd, domain->yz, domain->xz, domain->xy};
  double between[3];
  image_difference(xi, xj, image_shift(of_ghost.along, edges), ghost_is_j, true, true, between);
  return {between[0], between[1], between[2]};
}

/* Velocity of sphere i relative to sphere j. */
PairGranHysteretic::Vector PairGranHysteretic::relative_velocity(int i, int j) const
{
  const double *const vi = atom->v[i], *const vj = atom->v[j];
  const bool ghost_is_j = images(i).none();
  const auto &of_ghost = images(ghost_is_j ? j : i);
  if (!flows || of_ghost.none()) return plain_difference(vi, vj);
  const int group = domain->deform_groupbit;
  double relative[3];
  image_difference(vi, vj, image_shift(of_ghost.along, domain->h_rate), ghost_is_j, (atom->mask[i] & group) != 0,
                   (atom->mask[j] & group) != 0, relative);
  return {relative[0], relative[1], relative[2]};
}

/* Shift the ghosts of a triclinic box as in all later steps: after reneighboring LAMMPS has shifted them in units of the edges. */
void PairGranHysteretic::renew_ghosts()
{
  if (domain->triclinic) comm->forward_comm();
}

/* Replace the velocities of a batch, where there are pairs across the boundary of a box that flows. */
void PairGranHysteretic::set_relative_velocities(Batch &b) const
{
  for (int m = 0; m < b.size; m++) {
    if (!crosses(b.i[m], b.j[m])) continue;
    const Vector velocity = relative_velocity(b.i[m], b.j[m]);
    for (int d = 0; d < 3; d++) b.velocity[d][m] = velocity[d];
  }
}
