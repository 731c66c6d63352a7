// SPDX-License-Identifier: GPL-2.0-only
#include "resting_blocks.h"

#include "processors.h"

#include <algorithm>

using namespace granwave;

namespace {

/* Copy n coordinates from triples to arrays of their own. Returns true if one of them is another than before. */
template <bool COPY>
__attribute__((always_inline)) inline bool differs(const double *__restrict from, int n, double *__restrict x,
                                                   double *__restrict y, double *__restrict z)
{
  std::int64_t different = 0;
  for (int i = 0; i < n; i++) {
    const double xi = from[3 * i], yi = from[3 * i + 1], zi = from[3 * i + 2];
    different |= static_cast<std::int64_t>(xi != x[i]) | static_cast<std::int64_t>(yi != y[i]) |
                 static_cast<std::int64_t>(zi != z[i]);
    if (!COPY) continue;
    x[i] = xi;
    y[i] = yi;
    z[i] = zi;
  }
  return different != 0;
}

}    // namespace

FOR_EACH_PROCESSOR void granwave::compare_blocks(const double *from, int n, int size, double *x, double *y, double *z,
                                                 char *moved)
{
  for (int begin = 0, b = 0; begin < n; begin += size, b++, from += 3 * size, x += size, y += size, z += size) {
    const int count = std::min(size, n - begin);
    if (moved[b] || differs<false>(from, count, x, y, z)) moved[b] = differs<true>(from, count, x, y, z);
  }
}
