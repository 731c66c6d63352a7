// SPDX-License-Identifier: GPL-2.0-only
/* Cohesion of a contact by the work of adhesion w (energy per area, of both surfaces together). No LAMMPS types.

   JKR (Johnson, Kendall, Roberts 1971, Proc. R. Soc. A 324, 301), of elastic spheres. With the radius a of the contact circle

       overlap = a^2/R* - s sqrt(a)       F = (4/3) E* a^3/R* - 2 E* s a^(3/2)       s = sqrt(2 pi w/E*)

   The contact forms where the surfaces meet, at overlap 0, and is held by a neck down to overlap -3 a_f^2/R*, where it is no longer
   stable at any given displacement: a_f^3 = pi w R*^2/(8 E*). With x = sqrt(a/a_f), and the overlap in units of a_f^2/R*,

       overlap = x^4 - 4 x,   F = (4/3 x^6 - 8 x^3) E* a_f^3/R*,   energy = (8/15 x^10 - 16/3 x^7 + 8 x^4) E* a_f^5/R*^2,   x >= 1

   The energy is that of elasticity minus w times the area; 0 for surfaces apart. The largest pull is (3/2) pi w R*, that at the end
   5/9 of it, that where the surfaces meet 8/9. The energy falls by a jump where they meet, and by one where they part: both
   are lost, 30.478 and 3.2 in these units, 7.092 (w^5 R*^4/E*^2)^(1/3) together.

   DMT (Derjaguin, Muller, Toporov 1975): the force of any law of two materials, and the pull of the potential -2 pi w a^2, where the
   surfaces touch. Of Hertz's contacts, a^2 = R* overlap, this is 2 pi w R*. Of a dent a^2 grows with the loading curve, and below
   the peak is R_p (overlap - residual overlap): R_p is the radius of the dent (Thornton and Ning 1998, Powder Technol. 99, 154).
   Since it is a potential, losses are those of the law. */

#ifndef GRANWAVE_COHESION_H
#define GRANWAVE_COHESION_H

#include "material.h"
#include "power.h"

#include <algorithm>
#include <cmath>

namespace granwave {

enum class CohesionKind { NONE, JKR, DMT };

struct CohesionModel {
  CohesionKind kind = CohesionKind::NONE;
  double energy = 0.0;    // w

  explicit operator bool() const { return kind != CohesionKind::NONE; }
  bool operator==(const CohesionModel &other) const { return kind == other.kind && energy == other.energy; }
};

/* A cohesive contact whose surfaces touch, or are joined by a neck. All values are 0 for separate surfaces. */
struct CohesiveState {
  double force = 0.0;             // force, including the force of the law
  double energy = 0.0;            // likewise, stored
  double circle_squared = 0.0;    // squared radius of the contact circle
  double pressing = 0.0;          // normal force that limits friction: F plus twice the pull-off force, as in LAMMPS
};

/* Snap-in or separation of the surfaces: overlap, and force on the side where they touch. */
struct Jump {
  double overlap, force;
};

/* Contact after JKR. */
class Neck {
 public:
  Neck() = default;
  Neck(double modulus, double radius, double energy)
  {
    const double cubed = PI * energy * radius * radius / (8.0 * modulus), a = power(cubed, 1.0 / 3.0);
    circle_ = a * a;
    overlap_ = circle_ / radius;
    force_ = modulus * cubed / radius;
  }

  double length() const { return 3.0 * overlap_; }          // length of the neck at separation
  double pull_off() const { return 12.0 * force_; }         // largest pull
  double balanced() const { return BALANCE * overlap_; }    // overlap without force
  Jump jump(bool meets) const { return meets ? Jump{0.0, -32.0 / 3.0 * force_} : Jump{-length(), -20.0 / 3.0 * force_}; }

  /* Slope of the force; large and negative where the surfaces separate. */
  double stiffness(double overlap) const
  {
    const double x = root(overlap / overlap_ + 3.0), x3 = x * x * x;
    return x3 > 1.0 ? 2.0 * x * x * (x3 - 3.0) / (x3 - 1.0) * force_ / overlap_ : -INFINITE;
  }

  CohesiveState at(double overlap) const
  {
    const double x = root(overlap / overlap_ + 3.0), x2 = x * x, x3 = x2 * x, x4 = x2 * x2;
    CohesiveState s;
    s.force = (4.0 / 3.0 * x3 - 8.0) * x3 * force_;
    s.energy = ((8.0 / 15.0 * x3 - 16.0 / 3.0) * x3 + 8.0) * x4 * force_ * overlap_;
    s.circle_squared = circle_ * x4;
    s.pressing = s.force + 2.0 * pull_off();
    return s;
  }

 private:
  static constexpr double BALANCE = 3.6342411856642793;    // x^4 - 4 x for x^3 = 6
  static constexpr int STEPS = 8;                          // most iterations of Newton's method
  static constexpr double PRECISION = 1e-8;    // relative step of the last iteration; the next would be its square

  double circle_ = 0.0, overlap_ = 0.0, force_ = 0.0;

  /* Root x >= 1 of x^4 - 4 x + 3 = (x - 1)^2 (x^2 + 2 x + 3) = e. The square root of both sides is convex with a slope above 2, so
     that Newton's method converges from an upper bound. */
  static double root(double e)
  {
    if (!(e > 0.0)) return 1.0;
    const double wanted = std::sqrt(e);
    double x = 1.0 + std::min(wanted / std::sqrt(6.0), std::sqrt(wanted));
    for (int n = 0; n < STEPS; n++) {
      const double square = x * x + 2.0 * x + 3.0, rooted = std::sqrt(square);
      const double step = ((x - 1.0) * rooted - wanted) * rooted / (square + (x - 1.0) * (x + 1.0));
      x -= step;
      if (std::fabs(step) <= PRECISION * x) break;
    }
    return x;
  }
};

/* Cohesive history of a contact; all members are doubles, for communication. The loss is kept after separation.

   The force jumps where surfaces meet or part. Velocity Verlet knows the forces of both ends of a step alone and would err by an impulse
   of up to half a step; this is made good by a force at its end, which acts for a whole step, so that the error is of second
   order as elsewhere. What is lost in a jump is the work of the step minus the increase of the stored energy; the
   work of the added force belongs to two steps, of which the second may take back some per cent. */
struct CohesionHistory {
  double joined = 0.0;     // 1 if the surfaces touched, or were held by a neck, at the last step
  double overlap = 0.0;    // overlap at the last step
  double added = 0.0;      // force that compensated the jump of the last step
  double lost = 0.0;       // energy

  static constexpr int SIZE = 4;

  bool active() const { return joined > 0.0 || added != 0.0; }
  void forget_state() { joined = overlap = added = 0.0; }

  /* Advance by a step to the present overlap. Returns the force to be added.

     state, last     now, and where the force jumps at the last step
     jump            where it does
     first_moved     change of the overlap in this step if nothing is known of the last one
     loses           true for JKR: a jump is a loss; the jump of DMT is one of the force alone */
  double advance(double present, bool joins, const CohesiveState &state, const CohesiveState &last, const Jump &jump,
                 double first_moved, bool loses)
  {
    const bool jumps = joins != (joined > 0.0);
    const double moved = active() ? present - overlap : first_moved;
    double adds = 0.0;
    if (jumps && moved != 0.0) {
      const double after = std::min(std::max((present - jump.overlap) / moved, 0.0), 1.0);    // fraction of the step
      adds = jump.force * (joins ? after - 0.5 : 0.5 - after);
    }
    if (loses) lost += 0.5 * (added + adds) * moved;
    if (loses && jumps) lost += 0.5 * (last.force + state.force) * moved - (state.energy - last.energy);
    set(present, joins, adds);
    return adds;
  }

  /* Start from a state, or continue from the state of the last step. Returns the force to be added. */
  double start(double present, bool joins, double rounding)
  {
    if (active() && std::fabs(present - overlap) <= rounding) return added;
    set(present, joins, 0.0);
    return 0.0;
  }

 private:
  void set(double present, bool joins, double adds)
  {
    joined = joins ? 1.0 : 0.0;
    overlap = joins || adds != 0.0 ? present : 0.0;
    added = adds;
  }
};

}    // namespace granwave

#endif
