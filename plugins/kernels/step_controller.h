// SPDX-License-Identifier: GPL-2.0-only
/* Choice of the timestep from the error of the energy balance. No LAMMPS types.

   Velocity Verlet with the step dt keeps a shadow energy, H + dt^2 s up to higher orders, where

       s = q/24 - (dp/dt)/12      p = sum f.v + sum torque.omega      q = sum f^2/m + sum torque^2/I

   The balance is thus off by dt^2 (s_0 - s), with s_0 at the start; a change of the step moves s_0, and leaves
   (dt_new^2 - dt_old^2) s of that moment in the balance for good. Steps are a power of two times a tick. The step is
   doubled where 60 % of what is left of the allowed error would do for it if s went on swinging as it did, and only at
   multiples of the longer step; it is halved, at any time, before the error passes what is allowed.

   s is in units of energy/tick^2. */

#ifndef GRANWAVE_STEP_CONTROLLER_H
#define GRANWAVE_STEP_CONTROLLER_H

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace granwave {

class StepController {
 public:
  StepController(std::int64_t first, std::int64_t longest) : longest(longest) { ticks_ = wanted_ = first; }

  /* Record s after a step, and choose the ticks of the next step. It begins at tick `now` and ends at `due` or before;
     `allowed` is the largest error of the energy, `bound` the most ticks for other reasons. */
  std::int64_t choose(double s, double allowed, double bound, std::int64_t now, std::int64_t due)
  {
    bound_ = bound;
    const bool growing = std::fabs(s) > swing_;
    steps_++;
    since_++;
    const double memory = MEMORY + MEMORY_SHARE * static_cast<double>(steps_);
    swing_ = std::max(std::fabs(s), swing_ * (1.0 - LN_2 / memory));
    while (wanted_ > 1 && static_cast<double>(wanted_) > bound_) want(wanted_ / 2);
    if (std::isfinite(s) && allowed > 0.0) {
      while (wanted_ > 1 && too_long(s, allowed, growing)) want(wanted_ / 2);
      if (since_ >= DWELL) lengthen(s, allowed, now);
    } else {
      want(1);
    }
    std::int64_t next = wanted_;
    while (next > 1 && (now % next != 0 || now + next > due)) next /= 2;
    take(next, s);
    return next;
  }

  /* Set the number of ticks of the next step. */
  void take(std::int64_t ticks, double s)
  {
    if (ticks == ticks_) return;
    left_ = error(s);
    start_ = s;
    ticks_ = ticks;
  }

  /* Correct the error of the energy balance by a measured value. */
  void correct(double s, double measured) { left_ += measured - error(s); }

  /* Record an increase of s that is not due to motion, such as atoms that were added or deleted. */
  void shift(double more) { start_ += more; }

  /* Error of the energy balance now. */
  double error(double s) const { return left_ + square(ticks_) * (start_ - s); }

  /* State in a restart file. */
  std::vector<double> state() const
  {
    return {double(ticks_), double(wanted_), double(steps_), double(since_), start_, left_, swing_, swing_before_};
  }

  /* Read a state from a restart file. Returns the ticks of the present step. */
  std::int64_t restore(const double *state)
  {
    for (std::int64_t *number : {&ticks_, &wanted_, &steps_, &since_}) *number = static_cast<std::int64_t>(*state++);
    for (double *number : {&start_, &left_, &swing_, &swing_before_}) *number = *state++;
    return ticks_;
  }

 private:
  static constexpr double LN_2 = 0.6931471805599453;
  // initial number of steps over which half of the oscillation is forgotten,
  static constexpr double MEMORY = 50.0;
  static constexpr double MEMORY_SHARE = 0.03;    // and fraction of all previous steps: returns occur later and later
  static constexpr std::int64_t DWELL = 32;       // steps between two doublings
  // fraction of the remaining allowed error: a larger error makes the step shorter
  static constexpr double USED = 0.9;
  static constexpr double USED_WHILE_GROWING = 0.3;    // the same while s grows, as it will for several more steps
  static constexpr double USED_WHEN_LONGER = 0.6;      // after a doubling
  // fraction of the allowed error that is used for any earlier error
  static constexpr double LEAST_USED = 0.02;
  // fraction of the allowed error for changes of the step that are made immediately
  static constexpr double LEFT = 0.25;

  static double square(std::int64_t ticks) { return static_cast<double>(ticks) * static_cast<double>(ticks); }

  void want(std::int64_t ticks)
  {
    wanted_ = ticks;
    since_ = 0;
    swing_before_ = swing_;
  }

  /* Mean of the oscillating error with this step. */
  double centre(std::int64_t ticks, double s) const
  {
    return ticks == ticks_ ? left_ + square(ticks) * start_ : error(s) + square(ticks) * s;
  }

  bool too_long(double s, double allowed, bool growing) const
  {
    const double rest = (growing ? USED_WHILE_GROWING : USED) * (allowed - std::fabs(centre(wanted_, s)));
    return square(wanted_) * swing_ > std::max(rest, LEAST_USED * allowed);
  }

  void lengthen(double s, double allowed, std::int64_t now)
  {
    const std::int64_t longer = 2 * wanted_;
    if (longer <= longest && static_cast<double>(longer) <= bound_ && now % longer == 0 && swing_ <= swing_before_) {
      // accumulated errors of changes are kept small: a change waits for a moment at which its error compensates the errors of earlier changes
      const double made = std::fabs(centre(ticks_, s)), then = std::fabs(centre(longer, s));
      const double most = std::max(USED_WHEN_LONGER * (allowed - then), LEAST_USED * allowed);
      if (then <= std::max(made, LEFT * allowed) && square(longer) * swing_ <= most) return want(longer);
    }
    if (since_ % DWELL == 0) swing_before_ = swing_;
  }

  std::int64_t longest;
  double bound_ = 0.0;
  std::int64_t ticks_ = 1;       // length of the present step
  std::int64_t wanted_ = 1;      // length of a step that need not end early for an output
  std::int64_t steps_ = 0;       // taken
  std::int64_t since_ = 0;       // steps since its last change
  double start_ = 0.0;           // s at the start of the present step
  double left_ = 0.0;            // error due to earlier changes of the step
  double swing_ = 0.0;           // largest recent |s|
  double swing_before_ = 0.0;    // the same at the last change of the desired step
};

}    // namespace granwave

#endif
