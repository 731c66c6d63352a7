// SPDX-License-Identifier: GPL-2.0-only
/* Powers, exponentials and natural logarithms without branches and tables, so that loops with them can be vectorized. No LAMMPS
   types.

   The results are the same to the last bit on all processors and with any C library, and less than one unit in the last place
   from the exact ones. The methods and coefficients are those of fdlibm (e_pow.c, e_exp.c, e_log.c), whose notice is:

       Copyright (C) 1993, 2004 by Sun Microsystems, Inc. All rights reserved.
       Permission to use, copy, modify, and distribute this software is freely granted, provided that this notice is
       preserved. */

#ifndef GRANWAVE_POWER_H
#define GRANWAVE_POWER_H

#include "kernel.h"

#include <cstdint>
#include <cstring>

namespace granwave {

namespace power_parts {

GRANWAVE_KERNEL std::uint64_t bits_of(double x)
{
  std::uint64_t bits;
  std::memcpy(&bits, &x, sizeof(bits));
  return bits;
}

GRANWAVE_KERNEL double double_of(std::uint64_t bits)
{
  double x;
  std::memcpy(&x, &bits, sizeof(x));
  return x;
}

/* The first 21 bits of the mantissa: products of two such numbers are exact. */
GRANWAVE_KERNEL double upper(double x) { return double_of(bits_of(x) & 0xffffffff00000000); }

/* The nearest integer: beyond 2^52 doubles are integers. */
GRANWAVE_KERNEL double nearest(double x) { return (x + 0x1.8p52) - 0x1.8p52; }

/* 2^n for an integer, limited to the range from -1022 to 1023. */
GRANWAVE_KERNEL double power_of_two(double n)
{
  const double limited = n < -1022.0 ? -1022.0 : n > 1023.0 ? 1023.0 : n;
  return double_of(bits_of(limited + (0x1p52 + 1023.0)) << 52);
}

/* z - 2 z / (exp(z) - 1) + z: a polynomial in z^2, for |z| < 0.35. */
GRANWAVE_KERNEL double remainder_of_exponential(double z)
{
  const double t = z * z;
  return z -
         t * (1.66666666666666019037e-01 +
              t * (-2.77777777770155933842e-03 +
                   t * (6.61375632143793436117e-05 + t * (-1.65339022054652515390e-06 + t * 4.13813679705723846039e-08))));
}

}    // namespace power_parts

/* exp(x) for x < 709; below -708 it stays at 2^-1022. */
GRANWAVE_KERNEL double exponential(double x)
{
  using namespace power_parts;
  const double n = nearest(x * 1.44269504088896338700e+00);
  const double hi = x - n * 6.93147180369123816490e-01, lo = n * 1.90821492927058770002e-10, z = hi - lo;
  const double c = remainder_of_exponential(z);
  return (1.0 - ((lo - (z * c) / (2.0 - c)) - hi)) * power_of_two(n);
}

/* x^y for positive x, neither denormal nor infinite; results are limited to the range of normal numbers. 1^y = 1. */
GRANWAVE_KERNEL double power(double x, double y)
{
  using namespace power_parts;
  // x = 2^n m, with m from sqrt(3)/2 to sqrt(3) in two intervals around 1 and 3/2
  const std::uint64_t bits = bits_of(x);
  const double mantissa = double_of((bits & 0x000fffffffffffff) | 0x3ff0000000000000);
  const double exponent = double_of(bits >> 52 | 0x4330000000000000) - (0x1p52 + 1023.0);
  const bool high = mantissa >= 1.7320508075688772, middle = mantissa > 1.2247448713915890 && !high;
  const double m = high ? 0.5 * mantissa : mantissa, n = high ? exponent + 1.0 : exponent;
  const double center = middle ? 1.5 : 1.0;
  const double log_hi = middle ? 5.84962487220764160156e-01 : 0.0, log_lo = middle ? 1.35003920212974897128e-08 : 0.0;

  // s = (m - center)/(m + center) in two parts
  const double difference = m - center, inverse = 1.0 / (m + center), s = difference * inverse, s_hi = upper(s);
  const double sum_hi = upper(m + center), sum_lo = m - (sum_hi - center);
  const double s_lo = inverse * ((difference - s_hi * sum_hi) - s_hi * sum_lo);

  // log(m/center) = 2/3 s (3 + s^2 + ...), then log2(x) = t_hi + t_lo
  const double s2 = s * s, s2_hi = s_hi * s_hi;
  const double series = s2 * s2 *
                            (5.99999999999994648725e-01 +
                             s2 * (4.28571428578550184252e-01 +
                                   s2 * (3.33333329818377432918e-01 +
                                         s2 * (2.72728123808534006489e-01 +
                                               s2 * (2.30660745775561754067e-01 + s2 * 2.06975017800338417784e-01))))) +
                        s_lo * (s_hi + s);
  const double q_hi = upper(3.0 + s2_hi + series), q_lo = series - ((q_hi - 3.0) - s2_hi);
  const double u = s_hi * q_hi, w = s_lo * q_hi + q_lo * s, p_hi = upper(u + w), p_lo = w - (p_hi - u);
  const double z_hi = 9.61796700954437255859e-01 * p_hi;
  const double z_lo = -7.02846165095275826516e-09 * p_hi + p_lo * 9.61796693925975554329e-01 + log_lo;
  const double t_hi = upper(((z_hi + z_lo) + log_hi) + n), t_lo = z_lo - (((t_hi - n) - log_hi) - z_hi);

  // y log2(x) = whole + part, and 2^part
  const double y_hi = upper(y), product_lo = (y - y_hi) * t_hi + y * t_lo, product_hi = y_hi * t_hi;
  const double whole = nearest(product_lo + product_hi), part_hi = product_hi - whole, part = upper(product_lo + part_hi);
  const double e_hi = part * 6.93147182464599609375e-01;
  const double e_lo = (product_lo - (part - part_hi)) * 6.93147180559945286227e-01 + part * -1.90465429995776804525e-09;
  const double z = e_hi + e_lo, rest = e_lo - (z - e_hi), c = remainder_of_exponential(z);
  return (1.0 - (((z * c) / (c - 2.0) - (rest + z * rest)) - z)) * power_of_two(whole);
}

/* ln(x) of a positive normal number. */
GRANWAVE_KERNEL double logarithm(double x)
{
  const std::uint64_t bits = power_parts::bits_of(x);
  const double mantissa = power_parts::double_of((bits & 0x000fffffffffffff) | 0x3ff0000000000000);    // from 1 to 2
  const double exponent = power_parts::double_of(bits >> 52 | 0x4330000000000000) - (0x1p52 + 1023.0);
  const bool high = mantissa > 1.4142135623730951;
  const double m = high ? 0.5 * mantissa : mantissa, k = high ? exponent + 1.0 : exponent;
  const double f = m - 1.0, s = f / (2.0 + f), z = s * s, w = z * z;
  const double even = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
  const double odd = z * (6.666666666666735130e-01 +
                          w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
  const double half = 0.5 * f * f;
  return k * 6.93147180369123816490e-01 - ((half - (s * (half + (even + odd)) + k * 1.90821492927058770002e-10)) - f);
}

}    // namespace granwave

#endif
