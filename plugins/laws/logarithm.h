// SPDX-License-Identifier: GPL-2.0-only
/* Natural logarithm with the same bits on all processors and with any C library, less than one unit in the last place from the
   exact one. No LAMMPS types.

   The method and the coefficients are those of fdlibm (e_log.c), whose notice is:

       Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
       Permission to use, copy, modify, and distribute this software is freely granted, provided that this notice is
       preserved. */

#ifndef GRANWAVE_LOGARITHM_H
#define GRANWAVE_LOGARITHM_H

#include "power.h"

namespace granwave {

/* ln(x) of a positive normal number. */
inline double logarithm(double x)
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
