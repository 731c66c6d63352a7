// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: pairs across a periodic boundary.

   Such a pair is computed for each of its spheres i and j, once with j and a ghost of i, and once with i and a ghost of j. LAMMPS
   rounds the coordinates of ghosts, x_i - s and x_j + s with the shift s of the image, so that the vectors to them differ in their last
   bits. Both of these ghosts are known in both cases, since a coordinate that is there can be shifted as LAMMPS does it: the
   vector is computed from the two ghosts, as (x_i - s) - (x_j + s) + s. */

#include "pair_gran_hysteretic.h"

#include "comm.h"
#include "domain.h"

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

using Vector = std::array<double, 3>;

/* Shifts of a ghost along x, y and z by its images along the three edges of the box, one after the other, as LAMMPS makes them. */
std::array<Vector, 3> shifts_of(const std::int8_t images[3], const double edges[6])
{
  const double along_a = images[0], along_b = images[1], along_c = images[2];
  return {Vector{along_a * edges[0], along_b * edges[5], along_c * edges[4]},
          Vector{0.0, along_b * edges[1], along_c * edges[3]}, Vector{0.0, 0.0, along_c * edges[2]}};
}

/* Difference of two quantities of spheres i and j, of which one is that of a ghost, from those of the ghosts of both.

   shifts      those of the ghost
   ghost_is_j  true if the ghost is that of j
   shifted     _i, _j: whether the quantities of i and j are shifted with their ghosts */
Vector difference(const double *of_i, const double *of_j, const std::array<Vector, 3> &shifts, bool ghost_is_j,
                  bool shifted_i, bool shifted_j)
{
  Vector result;
  const bool present_is_shifted = ghost_is_j ? shifted_i : shifted_j;
  for (int d = 0; d < 3; d++) {
    double present = ghost_is_j ? of_i[d] : of_j[d], whole = 0.0;
    for (const double shift : shifts[d]) {
      if (present_is_shifted) present -= shift;
      whole += shift;
    }
    const double apart = ghost_is_j ? present - of_j[d] : of_i[d] - present;
    const double back = ghost_is_j ? whole : -whole;
    result[d] = shifted_i && shifted_j ? apart + back : apart;
  }
  return result;
}

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
  return difference(xi, xj, shifts_of(of_ghost.along, edges), ghost_is_j, true, true);
}

/* Velocity of sphere i relative to sphere j. */
PairGranHysteretic::Vector PairGranHysteretic::relative_velocity(int i, int j) const
{
  const double *const vi = atom->v[i], *const vj = atom->v[j];
  const bool ghost_is_j = images(i).none();
  const auto &of_ghost = images(ghost_is_j ? j : i);
  if (!flows || of_ghost.none()) return plain_difference(vi, vj);
  const int group = domain->deform_groupbit;
  return difference(vi, vj, shifts_of(of_ghost.along, domain->h_rate), ghost_is_j, (atom->mask[i] & group) != 0,
                    (atom->mask[j] & group) != 0);
}

/* Shift the ghosts of a triclinic box as in all later steps: after reneighboring LAMMPS has shifted them in units of the edges. */
void PairGranHysteretic::renew_ghosts()
{
  if (domain->triclinic) comm->forward_comm();
}

/* Replace the velocities of a batch if there are pairs across the boundary of a deforming box. */
void PairGranHysteretic::set_relative_velocities(Batch &b) const
{
  for (int m = 0; m < b.size; m++) {
    if (!crosses(b.i[m], b.j[m])) continue;
    const Vector velocity = relative_velocity(b.i[m], b.j[m]);
    for (int d = 0; d < 3; d++) b.velocity[d][m] = velocity[d];
  }
}
