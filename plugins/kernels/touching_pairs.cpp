// SPDX-License-Identifier: GPL-2.0-only
#include "touching_pairs.h"

#include "processors.h"

using namespace granwave;

namespace {

constexpr int LANES = RowGroup::LANES;
static_assert(LANES == 8 && RowGroup::PARTNERS == 8);    // a byte of bits for each row

using Numbers = FourDoubles;    // four rows at a time
using Bits = FourWords;

inline void load(Numbers &numbers, const double *from) { std::memcpy(&numbers, from, sizeof(numbers)); }

inline std::uint64_t any(const Bits &bits) { return static_cast<std::uint64_t>((bits[0] | bits[1]) | (bits[2] | bits[3])); }

/* Copy n coordinates from triples to an array for each direction. Returns true if any of them has changed. */
template <bool COPY>
ALWAYS_INLINE bool differs(const double *__restrict from, int n, double *__restrict x, double *__restrict y,
                           double *__restrict z)
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

FOR_EACH_PROCESSOR bool granwave::all_zero(const double *numbers, int n)
{
  if (n > 0 && numbers[0] != 0.0) return false;    // as nearly always where spheres move
  std::uint64_t sum = 0, bits;
  for (int i = 0; i < n; i++) {
    std::memcpy(&bits, numbers + i, sizeof(bits));
    sum |= bits << 1;    // without the sign
  }
  return sum == 0;
}

FOR_EACH_PROCESSOR bool granwave::all_finite(const double *numbers, int n)
{
  int others = 0;
  for (int i = 0; i < n; i++) others += numbers[i] - numbers[i] == 0.0 ? 0 : 1;
  return others == 0;
}

/* Compute the distances of the present group: which of its pairs touch, and which are beyond the gap. */
template <bool UNIFORM> ALWAYS_INLINE void TouchingPairs::measure()
{
  const RowGroup &g = *group;
  const double radsum = 2.0 * uniform_radius, touch_sq = touch_squared(radsum), forget_sq = (radsum + gap) * (radsum + gap);
  constexpr int WIDTH = sizeof(Numbers) / sizeof(double);
  Bits touches = {}, beyond = {};
  for (int first = 0; first < g.lanes; first += WIDTH) {
    const int i = g.sphere + first;
    Numbers xi, yi, zi, xj, yj, zj, ri, rj;
    load(xi, x + i);
    load(yi, y + i);
    load(zi, z + i);
    if (!UNIFORM) load(ri, radius + i);
    Numbers limit = Numbers{} + touch_sq, last = Numbers{} + forget_sq;
    Bits bit = Bits{1, 1 << 8, 1 << 16, 1 << 24} << 8 * first;    // of partner m, a byte for each row
    for (int m = 0; m < g.partners; m++, bit += bit) {
      const int j = g.partner[m] + first;
      load(xj, x + j);
      load(yj, y + j);
      load(zj, z + j);
      const Numbers delx = xi - xj, dely = yi - yj, delz = zi - zj;
      const Numbers rsq = delx * delx + dely * dely + delz * delz;
      std::memcpy(distances.delx[m] + first, &delx, sizeof(delx));
      std::memcpy(distances.dely[m] + first, &dely, sizeof(dely));
      std::memcpy(distances.delz[m] + first, &delz, sizeof(delz));
      std::memcpy(distances.rsq[m] + first, &rsq, sizeof(rsq));
      if (!UNIFORM) {
        load(rj, radius + j);
        const Numbers sum = ri + rj;
        limit = sum * sum * touch_squared(1.0);
        last = (sum + gap) * (sum + gap);
      }
      touches |= ~(rsq >= limit) & bit;    // NaN touches
      beyond |= (rsq > last) & bit;
    }
  }
  const std::uint64_t used = g.lanes == LANES ? ~std::uint64_t(0) : (std::uint64_t(1) << 8 * g.lanes) - 1;
  touching = any(touches) & used;
  for (std::uint64_t rest = any(beyond) & used; rest != 0; rest &= rest - 1) far.push_back(pair_of(lowest_bit(rest)));
}

/* Find the pairs of the present group that have separated. */
inline void TouchingPairs::compare()
{
  for (std::uint64_t rest = *before & ~touching; rest != 0; rest &= rest - 1) parted.push_back(pair_of(lowest_bit(rest)));
  *before = touching;
}

/* Search a group of one row; `n` pairs are in the batch before, and the number of pairs after it is returned. A pair is
   written to the batch whether it touches or not, and the next one takes its place if it does not. */
template <bool UNIFORM> ALWAYS_INLINE int TouchingPairs::search_row(ContactBatch &batch, int n)
{
  const RowGroup &g = *group;
  const int i = g.sphere;
  // in registers: the compiler cannot know that what is written to the batch leaves them unchanged
  const double *const along_x = x, *const along_y = y, *const along_z = z;
  const double xi = x[i], yi = y[i], zi = z[i], reach = gap;
  const double uniform_sum = 2.0 * uniform_radius;
  double touch_sq = touch_squared(uniform_sum), forget_sq = (uniform_sum + reach) * (uniform_sum + reach);
  std::uint64_t apart = 0, touching_now = 0;
  for (int m = 0; m < g.partners; m++) {
    const int j = g.partner[m];
    const double delx = xi - along_x[j], dely = yi - along_y[j], delz = zi - along_z[j];
    const double rsq = delx * delx + dely * dely + delz * delz;
    if (!UNIFORM) {
      const double radsum = radius[i] + radius[j];
      touch_sq = touch_squared(radsum);
      forget_sq = (radsum + reach) * (radsum + reach);
    }
    const bool touches = !(rsq >= touch_sq);    // NaN touches
    batch.put(n, g.pair + m, i, j, delx, dely, delz, rsq);
    n += touches;
    apart |= static_cast<std::uint64_t>(rsq > forget_sq) << m;
    touching_now |= static_cast<std::uint64_t>(touches) << m;
  }
  touching = touching_now;
  if (before) compare();
  for (; apart != 0; apart &= apart - 1) far.push_back(g.pair + lowest_bit(apart));
  return n;
}

template <bool UNIFORM> ALWAYS_INLINE bool TouchingPairs::search(ContactBatch &batch)
{
  constexpr int CAPACITY = ContactBatch::CAPACITY;
  const Distances &d = distances;
  int n = batch.size;
  for (; group != end; group++, before += before != nullptr, measured = false) {
    if (group->lanes == 1 && !measured && n + group->partners <= CAPACITY) {
      n = search_row<UNIFORM>(batch, n);
      continue;
    }
    if (!measured) {
      measure<UNIFORM>();
      if (before) compare();
      measured = true;
    }
    const RowGroup &g = *group;
    std::uint64_t rest = touching;
    for (; rest != 0 && n < CAPACITY; rest &= rest - 1) {    // row by row
      const int at = lowest_bit(rest), l = at >> 3, m = at & 7;
      batch.put(n, g.pair + l * g.stride + m, g.sphere + l, g.partner[m] + l, d.delx[m][l], d.dely[m][l], d.delz[m][l],
                d.rsq[m][l]);
      n++;
    }
    touching = rest;
    if (rest != 0) break;
  }
  batch.size = n;
  return group == end;
}

FOR_FOUR_DOUBLES bool TouchingPairs::collect(ContactBatch &batch)
{
  far.clear();
  parted.clear();
  return radius ? search<false>(batch) : search<true>(batch);
}
