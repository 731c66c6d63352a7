// SPDX-License-Identifier: GPL-2.0-only
#include "touching_pairs.h"

#include "processors.h"

#include <algorithm>

using namespace granwave;

#define INLINE __attribute__((always_inline)) inline

/* Distances squared of four pairs. */

INLINE void compute_rsq(const double *x, const int *i, const int *j, Components &rsq)
{
  Components del[4], by_axis[4], xi, xj;
  for (int q = 0; q < 4; q++) {
    read(xi, x + 3 * i[q]);    // the fourth is not used
    read(xj, x + 3 * j[q]);
    del[q] = xi - xj;
  }
  transpose(del, by_axis);
  rsq = by_axis[0] * by_axis[0] + by_axis[1] * by_axis[1] + by_axis[2] * by_axis[2];
}

/* Compute the distances of the pairs from `base` on, and find those that touch. */

template <bool UNIFORM> INLINE void TouchingPairs::compute_distances(int count, bool &any_far)
{
  const int *const j = partner + base;
  const double radsum = 2.0 * uniform_radius, touch_sq = touch_squared(radsum), forget_sq = (radsum + gap) * (radsum + gap);
  ComponentMask beyond = {};
  const auto keep = [&](int p, const int *of_i, const int *of_j) {
    Components squared;
    compute_rsq(x, of_i, of_j, squared);
    write(rsq + p, squared);
    if (UNIFORM) beyond |= squared > forget_sq;
  };
  int p = 0;
  for (; p + 4 <= count; p += 4) keep(p, sphere + p, j + p);
  if (p < count) {    // the last pair again
    int i_last[4], j_last[4];
    for (int q = 0; q < 4; q++) {
      i_last[q] = sphere[std::min(p + q, count - 1)];
      j_last[q] = j[std::min(p + q, count - 1)];
    }
    keep(p, i_last, j_last);
  }
  any_far = beyond[0] | beyond[1] | beyond[2] | beyond[3];
  int n = 0;
  for (p = 0; p < count; p++) {
    found[n] = p;
    if (UNIFORM) {
      n += !(rsq[p] >= touch_sq);    // NaN touches
    } else {
      const double sum = radius[sphere[p]] + radius[j[p]];
      n += !(rsq[p] >= touch_squared(sum));
      any_far |= rsq[p] > (sum + gap) * (sum + gap);
    }
  }
  n_found = n;
}

void TouchingPairs::find_far(int first_row, int count)
{
  for (int at = first_row; at < end && begin[at] < base + count; at++) {
    bool is_far = false;
    for (int k = std::max(base, begin[at]); k < std::min(base + count, begin[at + 1]); k++) {
      const double sum = radius ? radius[row[at]] + radius[partner[k]] : 2.0 * uniform_radius;
      is_far |= rsq[k - base] > (sum + gap) * (sum + gap);
    }
    far[n_far] = at;
    n_far += is_far;
  }
}

void TouchingPairs::find_released(int count)
{
  for (int p = 0, n = 0; p < count; p++) {
    const bool touches = n < n_found && found[n] == p;
    n += touches;
    released[n_released] = base + p;
    n_released += !touches && has_spring[base + p];
  }
}

/* Find the pairs that touch among the next ones. */

template <bool UNIFORM> INLINE void TouchingPairs::search()
{
  const int first_row = r, last = std::min(begin[end], pair + CHUNK), count = last - pair;
  base = pair;
  while (r < end) {
    const int next = std::min(begin[r + 1], last);
    for (int k = pair; k < next; k += GROUP) std::fill_n(sphere + (k - base), GROUP, row[r]);
    pair = next;
    if (begin[r + 1] > last) break;
    r++;
  }
  taken = n_found = 0;
  if (count == 0) return;
  for (int p = 0; p < CHUNK; p += 8) __builtin_prefetch(peak + (base + CHUNK + p));
  bool any_far;
  compute_distances<UNIFORM>(count, any_far);
  if (any_far) find_far(first_row, count);
  if (has_spring) {
    int springs = 0, held = 0;
    for (int p = 0; p < count; p++) springs += has_spring[base + p];
    for (int n = 0; n < n_found; n++) held += has_spring[base + found[n]];
    if (springs > held) find_released(count);
  }
  if (n_found > 0) std::fill_n(found + n_found, GROUP, found[n_found - 1]);
}

FOR_EACH_PROCESSOR bool TouchingPairs::collect(ContactBatch &batch)
{
  n_released = n_far = 0;
  if (taken == n_found) {
    if (radius) search<false>();
    else search<true>();
  }
  const int n = std::min(ContactBatch::CAPACITY, n_found - taken);
  const int *const chosen = found + taken;
  batch.size = n;
  for (int m = 0; m < batch.padded_size(); m++) {
    const int p = chosen[m], k = base + p, i = sphere[p], j = partner[k];
    Components xi, xj;
    read(xi, x + 3 * i);
    read(xj, x + 3 * j);
    batch.k[m] = k;
    batch.i[m] = i;
    batch.j[m] = j;
    batch.del[m] = xi - xj;
    batch.rsq[m] = rsq[p];
  }
  taken += n;
  return taken == n_found && r == end;
}
