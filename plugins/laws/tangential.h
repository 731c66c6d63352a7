// SPDX-License-Identifier: GPL-2.0-only
/* Tangential spring of a contact with friction, after Mindlin and Coulomb: its force, its update by the slip of a timestep,
   and its stored and dissipated energy. Used by the pair style and by the walls. No LAMMPS types.

   n is the unit normal towards the first body. In a timestep with slip s (relative displacement of the surfaces, first minus
   second, in the tangent plane), the force F on the first body is updated by

       rotation into the present tangent plane, with unchanged magnitude
       F <- F min(1, k/k_before)     rescaling as the contact circle shrinks; omitted with TangentialModel::MINDLIN, for
                                     comparison with programs that omit it
       F <- F - k s                  k = 8 G* a, a = present radius of the contact circle
       |F| <= limit = mu F_n         Coulomb

   The stored energy is F^2/(2k). The frictional loss is the work against the slip, (F_before + F)/2 . (-s) as in velocity
   Verlet, minus the increase of the stored energy. Without rescaling, a spring that is stretched while the circle is large and
   released while it is small would return more energy than it absorbed.

   The lever arm of each body is radius - overlap/2, both for the velocity of its surface and for the torque, so that the power
   of force and torque is that of F on the slip. The two lever arms sum to the distance: angular momentum is conserved. */

#ifndef GRANWAVE_TANGENTIAL_H
#define GRANWAVE_TANGENTIAL_H

#include "kernel.h"

#include <cmath>

namespace granwave {

// force rescaled as the contact circle shrinks; force unchanged; or a row of springs (partial_slip.h)
enum class TangentialModel { MINDLIN_RESCALE, MINDLIN, PARTIAL_SLIP };

/* Tangential history of a contact. The loss is kept after separation, the force is not. */
struct TangentialSpring {
  double force[3] = {};       // force on the first body
  double compliance = 0.0;    // 1/k at the last step; 0: no spring
  double loss = 0.0;          // frictional loss since the first contact
};

GRANWAVE_KERNEL double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

GRANWAVE_KERNEL double tangential_force(const TangentialSpring &spring)
{
  return std::sqrt(dot(spring.force, spring.force));
}

GRANWAVE_KERNEL double tangential_energy(const TangentialSpring &spring)
{
  return 0.5 * dot(spring.force, spring.force) * spring.compliance;
}

/* Slip in a timestep. `velocity` is that of the first body relative to the second at their centers, `spin` the sum of lever
   arm times angular velocity over both bodies (0 for a plane). */
GRANWAVE_KERNEL void slip_of_step(const double (&velocity)[3], const double (&spin)[3], const double (&n)[3], double dt,
                                  double (&slip)[3])
{
  const double along = dot(velocity, n);
  slip[0] = (velocity[0] - along * n[0] - (spin[1] * n[2] - spin[2] * n[1])) * dt;
  slip[1] = (velocity[1] - along * n[1] - (spin[2] * n[0] - spin[0] * n[2])) * dt;
  slip[2] = (velocity[2] - along * n[2] - (spin[0] * n[1] - spin[1] * n[0])) * dt;
}

/* Torque on either body per unit of its lever arm. */
GRANWAVE_KERNEL void torque_per_lever(const double (&n)[3], const double (&force)[3], double (&torque)[3])
{
  torque[0] = -(n[1] * force[2] - n[2] * force[1]);
  torque[1] = -(n[2] * force[0] - n[0] * force[2]);
  torque[2] = -(n[0] * force[1] - n[1] * force[0]);
}

/* Rotate the force into the plane normal to n with unchanged magnitude, whose square is given. No branches (contact_batch.h). */
GRANWAVE_KERNEL void rotate(TangentialSpring &spring, double square, const double (&n)[3])
{
  const double along = dot(spring.force, n), rest = square - along * along;
  const bool turns = rest > 0.0;    // otherwise the force is parallel to n, or negligible
  const double taken = turns ? along : 0.0, stretch = turns ? std::sqrt(square / rest) : 1.0;
  for (int d = 0; d < 3; d++) spring.force[d] = stretch * (spring.force[d] - taken * n[d]);
}

/* Advance the spring by one timestep of a contact with positive normal force. */
GRANWAVE_KERNEL void compute_tangential(TangentialSpring &spring, const double (&n)[3], const double (&slip)[3],
                                        double stiffness, double limit, TangentialModel model)
{
  const double before = dot(spring.force, spring.force), stored = 0.5 * before * spring.compliance;
  rotate(spring, before, n);
  double work = dot(spring.force, slip);
  const double ratio = spring.compliance > 0.0 ? stiffness * spring.compliance : 1.0;
  const double kept = model == TangentialModel::MINDLIN_RESCALE && ratio < 1.0 ? ratio : 1.0;
  for (int d = 0; d < 3; d++) spring.force[d] = kept * spring.force[d] - stiffness * slip[d];
  spring.compliance = 1.0 / stiffness;
  const double grown = dot(spring.force, spring.force), most = limit * limit;
  const bool slides = grown > most;
  const double factor = slides ? limit / std::sqrt(grown) : 1.0, square = slides ? most : grown;
  for (int d = 0; d < 3; d++) spring.force[d] *= factor;
  work = -0.5 * (work + dot(spring.force, slip));
  const double lost = work - (0.5 * square * spring.compliance - stored);
  // With rescaling it is negative only by rounding, or negligibly if the slip of a step exceeds the elongation of the spring.
  spring.loss += model == TangentialModel::MINDLIN_RESCALE && lost < 0.0 ? 0.0 : lost;
}

/* Release the spring of separated surfaces: the stored energy is dissipated. */
GRANWAVE_KERNEL void release(TangentialSpring &spring)
{
  spring.loss += tangential_energy(spring);
  spring = {{0.0, 0.0, 0.0}, 0.0, spring.loss};
}

}    // namespace granwave

#endif
