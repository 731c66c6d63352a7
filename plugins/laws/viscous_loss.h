// SPDX-License-Identifier: GPL-2.0-only
/* Viscous damping of a contact, which grows with the rate of its overlap, for any normal law. No LAMMPS types.

   With the force P of the law and its slope k = dP/d(overlap), the tangent stiffness,

       F = max(0, P + c rate)      c = A k                          loss time A
                                   c = alpha sqrt((2/3) m* k)       dashpot alpha, m* = effective mass

   The first is a material of Young's modulus E (1 + A d/dt) (Kuwabara and Kono 1987; Brilliantov, Spahn, Hertzsch, Poeschel
   1996). The second is alpha sqrt(m* K) overlap^(1/4) for Hertz's P = K overlap^(3/2) (Tsuji, Tanaka, Ishida 1992): its
   restitution does not depend on the speed. Nothing pulls. The energy stored is that of the law, and (F - P) rate is lost, also
   where F is cut off.

   In velocity Verlet the velocities at hand are those of the middle of the step. The rate at its end is extrapolated from the
   last two steps, which makes the force accurate to the second order. The loss of a step is (F - P) of both ends times the
   change of the overlap: velocity Verlet takes just that from the kinetic energy, so that the ledger closes as well as without
   loss. */

#ifndef GRANWAVE_VISCOUS_LOSS_H
#define GRANWAVE_VISCOUS_LOSS_H

#include "law_parameters.h"
#include "prony_loss.h"

#include <algorithm>
#include <cmath>

namespace granwave {

inline constexpr LawParameter TANGENTIAL_LOSS =
    LawParameter("tangential", "x",
                 "tangential damping divided by normal damping, as x_gamma_t of LAMMPS's pair style granular; "
                 "limited by Coulomb friction; 1 according to Tsuji")
        .in(NOT_NEGATIVE)
        .in_cases({0.0, 1e3, true, true})
        .optional(0.0, 1.0)
        .after("loss_tangential");

enum class LossKind { NONE, TIME, DASHPOT, PRONY };

struct ViscousLoss {
  LossKind kind = LossKind::NONE;
  double value = 0.0;         // relaxation time, or factor of the dashpot
  double tangential = 0.0;    // tangential / normal damping (tangential_damping.h)
  PronySeries prony{};        // branches of viscoelastic grains, which have no damping coefficient (prony_loss.h)

  explicit operator bool() const { return kind != LossKind::NONE; }
  bool relaxes() const { return kind == LossKind::PRONY; }
  bool operator==(const ViscousLoss &other) const
  {
    return kind == other.kind && value == other.value && tangential == other.tangential && prony == other.prony;
  }

  /* Damping coefficient: force / rate of the overlap, from the tangent stiffness and the effective mass. */
  double coefficient(double stiffness, double mass) const
  {
    if (kind == LossKind::TIME) return value * stiffness;
    return kind == LossKind::DASHPOT ? value * std::sqrt(2.0 / 3.0 * mass * stiffness) : 0.0;
  }
};

/* Part F - P of the force. P is not negative. */
inline double viscous_force(double force, double coefficient, double rate) { return std::max(coefficient * rate, -force); }

/* Viscous history of a contact; all members are doubles, for communication. The energy lost and the largest force are kept
   after separation, the others are zero. */
struct ViscousHistory {
  double overlap = 0.0;       // overlap at the last step
  double force = 0.0;         // F - P at the last step
  double rate = 0.0;          // mean rate of the overlap in the last step
  double step = 0.0;          // duration of that step; 0: no earlier state
  double peak_force = 0.0;    // largest F so far
  double lost = 0.0;          // energy

  static constexpr int SIZE = 6;

  /* Advance by a step to the present overlap, with the force P of the law there. Returns F - P.

     first_rate    rate of the overlap from the present velocities, used if there is no earlier state */
  double advance(double present, double law_force, double coefficient, double first_rate, double dt)
  {
    const bool known = step > 0.0;
    const double moved = known ? present - overlap : first_rate * dt, mean = moved / dt;
    const double now = known ? mean + (mean - rate) * (dt / (dt + step)) : mean;
    const double viscous = viscous_force(law_force, coefficient, now);
    lost += 0.5 * (force + viscous) * moved;
    set(present, law_force, viscous, mean, dt);
    return viscous;
  }

  /* Start from a state whose velocities are those of the same instant. Returns F - P. */
  double start(double present, double law_force, double coefficient, double present_rate, double dt)
  {
    set(present, law_force, viscous_force(law_force, coefficient, present_rate), present_rate, dt);
    return force;
  }

  /* True if the last step ended at this overlap, up to rounding: a run is resumed. */
  bool continues(double present, double rounding) const { return step > 0.0 && std::fabs(present - overlap) <= rounding; }

  /* Surfaces that separated in the last step; the overlap is negative. */
  void release(double present)
  {
    if (step > 0.0) lost += 0.5 * force * (present - overlap);
    forget_state();
  }

  /* Set the state from the force P of the law and the part F - P of another model. */
  void keep(double present, double law_force, double other, double dt) { set(present, law_force, other, 0.0, dt); }

  void forget_state() { overlap = force = rate = step = 0.0; }

 private:
  void set(double present, double law_force, double viscous, double mean, double dt)
  {
    overlap = present;
    force = viscous;
    rate = mean;
    step = dt;
    peak_force = std::max(peak_force, law_force + viscous);
  }
};

}    // namespace granwave

#endif
