// SPDX-License-Identifier: GPL-2.0-only
/* Arrival of a wave at a contact: the instant at which a rising quantity, the overlap or the force, first passed a part of its
   largest value, which is known only at the end. No LAMMPS types.

   The first overlap at all is no instant of the physics: ahead of a wave in Hertzian contacts the overlap falls faster than
   exponentially, so that the rounding of the coordinates decides when it is first above zero. */

#ifndef GRANWAVE_FRONT_H
#define GRANWAVE_FRONT_H

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace granwave {

constexpr double ARRIVED = 0.1;    // part of the largest force of a contact at which a wave has arrived there

/* Times at which the quantity passed the three highest powers of four below its largest value, the latest first; -1 = never. */
struct Front {
  static constexpr int LEVELS = 3;

  double time[LEVELS] = {-1.0, -1.0, -1.0};

  /* Exponent of the highest power of four that is not above a positive number. */
  static int level(double value)
  {
    constexpr int MANTISSA = 52, BIAS = 1023;    // of the bits of a double
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof(bits));
    return (static_cast<int>(bits >> MANTISSA) + 1) / 2 - (BIAS + 1) / 2;
  }

  /* Return true if a power of four lies between two numbers, of which the first may be zero. */
  static bool crosses(double before, double value) { return before <= 0.0 || level(before) != level(value); }

  /* Note that the largest value rose in the step that ends now. */
  void rise(double before, double value, double now, double step)
  {
    const int highest = level(value);
    const int lowest = before > 0.0 ? std::max(level(before) + 1, highest - LEVELS + 1) : highest - LEVELS + 1;
    for (int k = lowest; k <= highest; k++) {
      const double left = before > 0.0 ? (value - std::ldexp(1.0, 2 * k)) / (value - before) : 0.0;
      std::copy_backward(time, time + LEVELS - 1, time + LEVELS);
      time[0] = std::max(now - left * step, 0.0);
    }
  }

  /* Time at which the quantity passed a part of its largest value, between a sixteenth of it and all; -1 = never. It is
     interpolated in the logarithm of the quantity by a parabola. */
  double passed(double largest, double part) const
  {
    if (time[0] < 0.0 || !(largest > 0.0)) return -1.0;
    const double middle = time[1] < 0.0 ? time[0] : time[1];
    const double first = time[2] < 0.0 ? middle : time[2];
    const double x = std::log2(part * largest) / 2.0 - level(largest);    // 0, -1 and -2 at the three levels
    const double parabola = 0.5 * (x + 1.0) * (x + 2.0) * time[0] - x * (x + 2.0) * middle + 0.5 * x * (x + 1.0) * first;
    return std::min(std::max(parabola, first), time[0]);
  }
};

}    // namespace granwave

#endif
