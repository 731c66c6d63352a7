// SPDX-License-Identifier: GPL-2.0-only
/* Tangential spring of a contact with friction, after Mindlin and Coulomb: its force, the change in a step of slip, stored
   and lost energy. Used by the pair style and by the walls. No LAMMPS types.

   n is the unit normal towards the first body. In a step with slip s (relative displacement of the surfaces, first minus
   second, in the tangent plane), the force F on the first body

       turns into the present tangent plane and keeps its length
       F <- F min(1, k/k_before)     a contact whose circle shrinks loses the force of the part that parts; left out by
                                     TangentialModel::MINDLIN, for comparison with programs that do so
       F <- F - k s                  k = 8 G* a, a = radius of the contact circle now
       |F| <= limit = mu F_n         Coulomb

   Stored is F^2/(2k). Lost is the work against the slip, (F_before + F)/2 . (-s) as velocity Verlet does it, less what the
   stored energy grew by. Unscaled, a spring stretched under a large circle would pull back more than it took.

   A body's surface meets the other at radius - overlap/2 from its centre. With that lever both for the velocity of the surface
   and for the torque, power in equals power out, and the two levers add up to the distance: angular momentum stays too. */

#ifndef GRANWAVE_TANGENTIAL_H
#define GRANWAVE_TANGENTIAL_H

#include <algorithm>
#include <cmath>

namespace granwave {

enum class TangentialModel { MINDLIN_RESCALE, MINDLIN };    // force scaled down where the circle shrinks, or kept

/* Tangential history of a contact. The loss outlives the contact; the force does not. */
struct TangentialSpring {
  double force[3] = {};       // on the first body
  double compliance = 0.0;    // 1/k at the last step; 0: no spring
  double loss = 0.0;          // frictional, since the first contact
};

inline double dot(const double (&a)[3], const double (&b)[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline double tangential_force(const TangentialSpring &spring) { return std::sqrt(dot(spring.force, spring.force)); }

inline double tangential_energy(const TangentialSpring &spring)
{
  return 0.5 * dot(spring.force, spring.force) * spring.compliance;
}

/* Slip of a step. `velocity` is that of the first body against the second at their centres, `spin` the sum of lever times
   angular velocity over both (a plane has none). */
inline void slip_of_step(const double (&velocity)[3], const double (&spin)[3], const double (&n)[3], double dt,
                         double (&slip)[3])
{
  const double along = dot(velocity, n);
  slip[0] = (velocity[0] - along * n[0] - (spin[1] * n[2] - spin[2] * n[1])) * dt;
  slip[1] = (velocity[1] - along * n[1] - (spin[2] * n[0] - spin[0] * n[2])) * dt;
  slip[2] = (velocity[2] - along * n[2] - (spin[0] * n[1] - spin[1] * n[0])) * dt;
}

/* Torque on either body per unit of its lever. */
inline void torque_per_lever(const double (&n)[3], const double (&force)[3], double (&torque)[3])
{
  torque[0] = -(n[1] * force[2] - n[2] * force[1]);
  torque[1] = -(n[2] * force[0] - n[0] * force[2]);
  torque[2] = -(n[0] * force[1] - n[1] * force[0]);
}

/* Rotate the force into the plane normal to n; it keeps its length, whose square is given. No branches (contact_batch.h). */
inline void rotate(TangentialSpring &spring, double square, const double (&n)[3])
{
  const double along = dot(spring.force, n), q = along * along / square;
  const bool turns = q < 1.0;    // else it points along n, or is next to nothing
  const double taken = turns ? along : 0.0, stretch = turns ? 1.0 / std::sqrt(1.0 - q) : 1.0;
  for (int d = 0; d < 3; d++) spring.force[d] = stretch * (spring.force[d] - taken * n[d]);
}

/* Advance the spring by one step of a contact that bears a normal force. */
inline void compute_tangential(TangentialSpring &spring, const double (&n)[3], const double (&slip)[3], double stiffness,
                               double limit, TangentialModel model)
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
  // rescaled it is negative by rounding alone, or where a step's slip is longer than the spring: next to nothing
  spring.loss += model == TangentialModel::MINDLIN_RESCALE && lost < 0.0 ? 0.0 : lost;
}

/* Release the spring of surfaces that have parted: what is stored is lost. */
inline void release(TangentialSpring &spring)
{
  spring.loss += tangential_energy(spring);
  spring = {{0.0, 0.0, 0.0}, 0.0, spring.loss};
}

}    // namespace granwave

#endif
