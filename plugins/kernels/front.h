// SPDX-License-Identifier: GPL-2.0-only
/* Arrival of a wave at a contact: the instant at which a rising quantity, the overlap or the force, first passed a part of its
   largest value, which is known only at the end. No LAMMPS types.

   The first overlap at all is no instant of the physics: ahead of a wave in Hertzian contacts the overlap falls faster than
   exponentially, so that the rounding of the coordinates decides when it is first above zero. */

#ifndef GRANWAVE_FRONT_H
#define GRANWAVE_FRONT_H

#include "../laws/kernel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace granwave {

constexpr double ARRIVED = 0.1;    // fraction of the largest force of a contact that marks the arrival of a wave

/* Times at which the quantity passed the six highest powers of two below its largest value, the latest first; -1 = never. Single
   precision resolves a timestep up to some million steps. */
struct Front {
  static constexpr int LEVELS = 6;

  float time[LEVELS] = {-1.0f, -1.0f, -1.0f, -1.0f, -1.0f, -1.0f};

  /* Exponent of the highest power of two that is not above a positive number. */
  GRANWAVE_KERNEL static int level(double value)
  {
    constexpr int MANTISSA = 52, BIAS = 1023;    // layout of the bits of a double
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof(bits));
    return static_cast<int>(bits >> MANTISSA) - BIAS;
  }

  /* Return true if a power of two lies between two numbers, of which the first may be zero. */
  GRANWAVE_KERNEL static bool crosses(double before, double value) { return before <= 0.0 || level(before) != level(value); }

  /* Record that the largest value increased in the current step. */
  GRANWAVE_KERNEL void rise(double before, double value, double now, double step)
  {
    const int highest = level(value);
    int lowest = highest - LEVELS + 1;
    if (before > 0.0 && level(before) + 1 > lowest) lowest = level(before) + 1;
    for (int k = lowest; k <= highest; k++) {
      const double left = before > 0.0 ? (value - std::ldexp(1.0, k)) / (value - before) : 0.0;
      for (int n = LEVELS - 1; n > 0; n--) time[n] = time[n - 1];
      time[0] = static_cast<float>(larger(now - left * step, 0.0));
    }
  }

  /* Time at which the quantity exceeded a given fraction of its largest value, at least a sixteenth; -1 = never. It is interpolated in
     the fourth root of the quantity, which rises about evenly in a solitary wave, by a parabola through the levels above and
     below, and that below them. */
  double passed(double largest, double part) const
  {
    if (time[0] < 0.0f || !(largest > 0.0)) return -1.0;
    constexpr int POINTS = 3;
    const int highest = level(largest);
    const int above = std::min(std::max(highest - level(part * largest) - 1, 0), LEVELS - POINTS);
    double x[POINTS], t[POINTS];
    for (int n = 0; n < POINTS; n++) {
      const float at = time[above + n];
      x[n] = fourth_root(std::ldexp(1.0, highest - above - n));
      t[n] = at >= 0.0f ? at : n > 0 ? t[n - 1] : time[0];    // loaded from the start
    }
    const double place = fourth_root(part * largest);
    const double parabola = t[0] * (place - x[1]) * (place - x[2]) / ((x[0] - x[1]) * (x[0] - x[2])) +
                            t[1] * (place - x[0]) * (place - x[2]) / ((x[1] - x[0]) * (x[1] - x[2])) +
                            t[2] * (place - x[0]) * (place - x[1]) / ((x[2] - x[0]) * (x[2] - x[1]));
    return std::min(std::max(parabola, t[1]), t[0]);
  }

 private:
  static double fourth_root(double value) { return std::sqrt(std::sqrt(value)); }
};

}    // namespace granwave

#endif
