// SPDX-License-Identifier: GPL-2.0-only
#include "touching_pairs.h"

#include "processors.h"

#include <algorithm>
#include <cstring>

using namespace granwave;

template <bool UNIFORM, bool FRICTION> __attribute__((always_inline)) inline bool TouchingPairs::search(ContactBatch &batch)
{
  constexpr int CAPACITY = ContactBatch::CAPACITY;
  const double radsum = 2.0 * uniform_radius;
  double touch_sq = touch_squared(radsum), forget_sq = (radsum + gap) * (radsum + gap);
  int n = 0, loose = 0, outside = 0, at = r, k = pair;    // in registers
  for (; at < end; at++) {
    const int i = row[at], next = begin[at + 1], last = std::min(next, k + CAPACITY - std::max(n, loose));
    Components xi, xj;
    std::memcpy(&xi, x + 3 * i, sizeof(xi));    // the fourth is not used
    int is_far = 0;
    for (; k < last; k++) {
      const int j = partner[k];
      std::memcpy(&xj, x + 3 * j, sizeof(xj));
      const Components del = xi - xj, square = del * del;
      const double rsq = square[0] + square[1] + square[2];
      if (!UNIFORM) {
        const double sum = radius[i] + radius[j];
        touch_sq = touch_squared(sum);
        forget_sq = (sum + gap) * (sum + gap);
      }
      const int touches = !(rsq >= touch_sq), of_touching = -touches;    // NaN touches
      batch.k[n] = k;
      batch.i[n] = i;
      batch.j[n] = j;
      batch.del[n] = del;
      batch.rsq[n] = rsq;
      n += touches;
      is_far |= rsq > forget_sq;
      // needed soon, and then not before the next step: it should not displace others from the cache
      __builtin_prefetch(peak + (k & of_touching), 0, 0);
      if (!FRICTION) continue;
      released[loose] = k;
      loose += (1 - touches) & has_spring[k];
      __builtin_prefetch(spring + (k & of_touching), 0, 0);
    }
    far[outside] = at;
    outside += is_far;
    if (k < next) break;
  }
  batch.size = n;
  n_released = loose;
  n_far = outside;
  r = at;
  pair = k;
  return at == end;
}

FOR_EACH_PROCESSOR bool TouchingPairs::collect(ContactBatch &batch)
{
  if (!radius) return has_spring ? search<true, true>(batch) : search<true, false>(batch);
  return has_spring ? search<false, true>(batch) : search<false, false>(batch);
}
