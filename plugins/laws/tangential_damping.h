// SPDX-License-Identifier: GPL-2.0-only
/* Damping of a contact along its surface, for any normal law with viscous damping and for each tangential model. No
   LAMMPS types.

   With the force S of the tangential spring (tangential.h), the velocity V of the surfaces along each other, and the coefficient c
   of the normal damping (viscous_loss.h), the force along the surface is

       F = S + D,  D = -x c V        x = ratio of the two dampings
       |F| <= limit                  mu F_n, F_n with the viscous force
       S <- F - D                    where it slides; D alone is at most `limit`

   That is the damping of the tangential models linear_history and mindlin of LAMMPS's pair style granular, where x is x_gamma_t;
   Tsuji, Tanaka, Ishida (1992) have x = 1. With partial slip each place of the contact circle has its part of spring, damping and
   limit.

   The velocity is that at the end of the step, extrapolated from the last two steps as in viscous_loss.h. The energy stored is that
   of the spring. With e the part of the slip s that stretches the spring, (D_before + D)/2 . (-e) is lost by the damping; the rest of
   the work against the slip, (F_before + F)/2 . (-s), minus the increase of the stored energy, is lost by friction: sliding at a
   constant speed loses by friction alone. */

#ifndef GRANWAVE_TANGENTIAL_DAMPING_H
#define GRANWAVE_TANGENTIAL_DAMPING_H

#include "tangential.h"

#include <algorithm>

namespace granwave {

/* Scale a vector to a magnitude of at most `most`. */
inline void limit_magnitude(double *vector, double most)
{
  const double square = dot(vector, vector);
  const double factor = square > most * most ? most / std::sqrt(square) : 1.0;
  for (int d = 0; d < 3; d++) vector[d] *= factor;
}

/* Scale the sum of spring force and damping force to a limit, by a change of the spring force. */
inline void limit_sum(double (&spring)[3], const double (&damping)[3], double limit)
{
  double sum[3];
  for (int d = 0; d < 3; d++) sum[d] = spring[d] + damping[d];
  if (dot(sum, sum) <= limit * limit) return;
  limit_magnitude(sum, limit);
  for (int d = 0; d < 3; d++) spring[d] = sum[d] - damping[d];
}

/* Rotate a vector into the plane normal to n with unchanged magnitude. */
inline void turn_into_plane(double *vector, const double (&n)[3])
{
  TangentialSpring as{{vector[0], vector[1], vector[2]}};
  rotate(as, dot(vector, vector), n);
  std::copy_n(as.force, 3, vector);
}

/* History of the damping of a contact, in its doubles. Vectors are those of the first body. The energy lost is kept after
   separation, the others are zero. */
class DampingHistory {
 public:
  enum {
    FORCE,       // D at the end of the last step
    RATE = 3,    // mean of V in the last step
    STEP = 6,    // duration of that step; 0: no earlier state
    LOST,        // energy
    SIZE
  };

  explicit DampingHistory(double *doubles) : doubles_(doubles) {}

  const double *force() const { return doubles_ + FORCE; }

  /* Begin a timestep: rotate into the present tangent plane, and compute -c V at its end, from the slip of the step. */
  void drag_of_step(const double (&n)[3], const double (&slip)[3], double coefficient, double dt, double (&drag)[3])
  {
    double *const rate = doubles_ + RATE, &step = doubles_[STEP];
    turn_into_plane(doubles_ + FORCE, n);
    turn_into_plane(rate, n);
    for (int d = 0; d < 3; d++) {
      const double mean = slip[d] / dt;
      const double now = step > 0.0 ? mean + (mean - rate[d]) * (dt / (dt + step)) : mean;
      drag[d] = -coefficient * now;
      rate[d] = mean;
    }
    step = dt;
  }

  /* End the step with the force D, and the energy dissipated in it. */
  void finish_step(const double (&found)[3], double energy)
  {
    std::copy_n(found, 3, doubles_ + FORCE);
    doubles_[LOST] += energy;
  }

  /* Start from a state whose velocities are those of the same instant; the spring is at rest. */
  void start(const double (&n)[3], const double (&slip)[3], const double (&spring)[3], double coefficient, double limit,
             double dt)
  {
    doubles_[STEP] = 0.0;
    double drag[3], sum[3];
    drag_of_step(n, slip, coefficient, dt, drag);
    for (int d = 0; d < 3; d++) sum[d] = drag[d] + spring[d];
    limit_magnitude(sum, limit);
    for (int d = 0; d < 3; d++) doubles_[FORCE + d] = sum[d] - spring[d];
  }

  void release() { std::fill_n(doubles_, static_cast<int>(LOST), 0.0); }
  void begin() { std::fill_n(doubles_, static_cast<int>(SIZE), 0.0); }

 private:
  double *doubles_;
};

/* Advance spring and damping by one timestep of a contact with positive normal force and one spring. */
inline void compute_damped(TangentialSpring &spring, DampingHistory damping, const double (&n)[3], const double (&slip)[3],
                           double stiffness, double limit, TangentialModel model, double coefficient, double dt)
{
  const double before = dot(spring.force, spring.force), stored = tangential_energy(spring);
  rotate(spring, before, n);
  double drag[3];
  damping.drag_of_step(n, slip, coefficient, dt, drag);
  limit_magnitude(drag, limit);
  double work = -0.5 * (dot(spring.force, slip) + dot(damping.force(), slip));
  const double ratio = spring.compliance > 0.0 ? stiffness * spring.compliance : 1.0;
  const double kept = model == TangentialModel::MINDLIN ? 1.0 : std::min(ratio, 1.0);
  double stretch[3];
  for (int d = 0; d < 3; d++) {
    stretch[d] = spring.force[d] *= kept;
    spring.force[d] -= stiffness * slip[d];
  }
  spring.compliance = 1.0 / stiffness;
  limit_sum(spring.force, drag, limit);
  for (int d = 0; d < 3; d++) stretch[d] = (stretch[d] - spring.force[d]) * spring.compliance;
  work -= 0.5 * (dot(spring.force, slip) + dot(drag, slip));
  const double damped = -0.5 * (dot(damping.force(), stretch) + dot(drag, stretch));
  spring.loss += work - (tangential_energy(spring) - stored) - damped;
  damping.finish_step(drag, damped);
}

}    // namespace granwave

#endif
