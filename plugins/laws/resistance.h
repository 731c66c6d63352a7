// SPDX-License-Identifier: GPL-2.0-only
/* Resistance of a contact to rolling and to twisting: springs, each with a dashpot and a slider, (Luding 2008, Granular
   Matter 10, 235; type C of Ai, Chen, Rotter and Ooi 2011), as `rolling sds`, `twisting sds` and `twisting marshall` of
   LAMMPS's pair style granular. No LAMMPS types.

   n is the unit normal towards the first body, w its angular velocity relative to the second, A the effective radius.

       rolling    velocity V = A w x n,  force F along the surface,  torque on the first body  A n x F
       twisting   velocity W = w . n,    torque on the first body M n

   The second body gets the opposite torques; both F and M are the same if first and second body are exchanged. In a timestep,
   with displacement s = V dt or W dt:

       spring  <- spring min(1, k/k_before) - k s         k constant, or it follows the contact circle of radius a: the tangential
                                                          spring's k_t = 8 G* a for rolling, k_t a^2/2 for twisting
       F = spring - gamma V,  |F| <= limit                mu F_n;  twisting marshall: (2/3) mu_friction a F_n
       spring <- F + gamma V where it slides              the part gamma V alone is at most `limit`

   The stored energy is spring^2/(2 k). The loss is the work against the displacement, (F_before + F)/2 . (-s) as in velocity
   Verlet, minus the increase of the stored energy. */

#ifndef GRANWAVE_RESISTANCE_H
#define GRANWAVE_RESISTANCE_H

#include "tangential_damping.h"

#include <algorithm>

namespace granwave {

/* Constants of one resistance. */
struct SliderModel {
  double stiffness = 0.0;      // N/m for rolling, N m for twisting; 0: it follows from the contact circle
  double damping = 0.0;        // N s/m; N m s
  double coefficient = 0.0;    // limit over the normal force: a number; a length
  bool marshall = false;       // for twisting: limit by the friction of the contact

  explicit operator bool() const { return coefficient > 0.0 || marshall; }
  bool operator==(const SliderModel &o) const
  {
    return stiffness == o.stiffness && damping == o.damping && coefficient == o.coefficient && marshall == o.marshall;
  }
};

struct ResistanceModel {
  SliderModel rolling, twisting;

  explicit operator bool() const { return rolling || twisting; }
  bool operator==(const ResistanceModel &other) const { return rolling == other.rolling && twisting == other.twisting; }
};

/* Spring, dashpot and slider in N dimensions; all members are doubles, for communication. The loss is kept after separation. */
template <int N> struct Slider {
  double spring[N] = {}, dashpot[N] = {};    // forces of both
  double compliance = 0.0;                   // 1/k at the last step; 0: no spring
  double loss = 0.0;

  double stored() const
  {
    double square = 0.0;
    for (const double force : spring) square += force * force;
    return 0.5 * square * compliance;
  }

  /* Advance by the displacement of a timestep, with a positive stiffness and limit. */
  void advance(const double *displacement, double stiffness, double damping, double limit, double dt)
  {
    const double before = stored(), ratio = compliance > 0.0 ? stiffness * compliance : 1.0, kept = std::min(ratio, 1.0);
    double work = 0.0, viscous = 0.0, square = 0.0;
    for (int d = 0; d < N; d++) {
      work -= 0.5 * (spring[d] + dashpot[d]) * displacement[d];
      spring[d] = kept * spring[d] - stiffness * displacement[d];
      dashpot[d] = -damping * displacement[d] / dt;
      viscous += dashpot[d] * dashpot[d];
    }
    const double part = viscous > limit * limit ? limit / std::sqrt(viscous) : 1.0;
    for (int d = 0; d < N; d++) {
      dashpot[d] *= part;
      square += (spring[d] + dashpot[d]) * (spring[d] + dashpot[d]);
    }
    const double factor = square > limit * limit ? limit / std::sqrt(square) : 1.0;
    for (int d = 0; d < N; d++) {
      const double force = factor * (spring[d] + dashpot[d]);
      if (factor < 1.0) spring[d] = force - dashpot[d];
      work -= 0.5 * force * displacement[d];
    }
    compliance = 1.0 / stiffness;
    loss += work - (stored() - before);
  }

  void release()
  {
    const double lost = loss + stored();
    *this = {};
    loss = lost;
  }
};

/* State of a contact with both resistances. */
struct RollingContact {
  double normal[3], spin[3];    // n and w
  double arm;                   // A
  double force;                 // normal force
  double circle;                // a
  double stiffness;             // k_t
  double friction;              // coefficient of friction
};

/* Resistance history of a contact; all members are doubles, for communication. */
struct ResistanceHistory {
  Slider<3> rolling;
  Slider<1> twisting;

  static constexpr int SIZE = 12;

  bool active() const { return rolling.compliance > 0.0 || twisting.compliance > 0.0; }
  double loss() const { return rolling.loss + twisting.loss; }
  double stored() const { return rolling.stored() + twisting.stored(); }

  /* Start a run: keep springs, set losses to 0. */
  void begin() { rolling.loss = twisting.loss = 0.0; }

  void advance(const ResistanceModel &model, const RollingContact &c, double dt)
  {
    const double (&n)[3] = c.normal, (&w)[3] = c.spin;
    const SliderModel &roll = model.rolling, &twist = model.twisting;
    if (const double k = roll.stiffness > 0.0 ? roll.stiffness : c.stiffness; roll && k > 0.0) {
      for (auto *vector : {&rolling.spring, &rolling.dashpot}) turn_into_plane(*vector, n);
      const double s[3] = {c.arm * (w[1] * n[2] - w[2] * n[1]) * dt, c.arm * (w[2] * n[0] - w[0] * n[2]) * dt,
                           c.arm * (w[0] * n[1] - w[1] * n[0]) * dt};
      rolling.advance(s, k, roll.damping, roll.coefficient * c.force, dt);
    }
    const double k = twist.stiffness > 0.0 ? twist.stiffness : 0.5 * c.stiffness * c.circle * c.circle;
    const double limit = (twist.marshall ? 2.0 / 3.0 * c.friction * c.circle : twist.coefficient) * c.force;
    if (!twist) return;
    if (!(k > 0.0 && limit > 0.0)) return twisting.release();
    const double s = dot(c.spin, c.normal) * dt;
    twisting.advance(&s, k, twist.damping, limit, dt);
  }

  /* Torque on the first body. */
  void torque(const double (&n)[3], double arm, double (&sum)[3]) const
  {
    double f[3];
    for (int d = 0; d < 3; d++) f[d] = rolling.spring[d] + rolling.dashpot[d];
    const double twist = twisting.spring[0] + twisting.dashpot[0];
    sum[0] = arm * (n[1] * f[2] - n[2] * f[1]) + twist * n[0];
    sum[1] = arm * (n[2] * f[0] - n[0] * f[2]) + twist * n[1];
    sum[2] = arm * (n[0] * f[1] - n[1] * f[0]) + twist * n[2];
  }

  void release()
  {
    rolling.release();
    twisting.release();
  }
};

}    // namespace granwave

#endif
