// SPDX-License-Identifier: GPL-2.0-only
/* Sums of forces or torques on spheres in twice the precision of a double. No LAMMPS types.

   The order in which the forces on a sphere are summed is that of the neighbor list, which depends on the number of
   processors. With twice the precision the rounded sum is the same in any order: runs are bitwise reproducible on any number
   of processors. */

#ifndef GRANWAVE_TWOFOLD_SUM_H
#define GRANWAVE_TWOFOLD_SUM_H

#include <cstddef>
#include <vector>

namespace granwave {

/* Three components and one unused, which the compiler adds at once (extension of GCC and Clang). */
typedef double Components __attribute__((vector_size(4 * sizeof(double))));

struct alignas(64) TwofoldSum {
  Components high = {}, low = {};

  void add(const Components &term)
  {
    const Components total = high + term, rounded = total - high;
    low += (high - (total - rounded)) + (term - rounded);    // rounding error of the addition (Knuth)
    high = total;
  }
};

/* One sum per sphere. With an ordered list only the sums between a row and its farthest partner are in use at a time, and a
   ring buffer of that size stays in the cache. All others are zero. */
class TwofoldSums {
 public:
  void reserve(int in_use)
  {
    std::size_t size = 1;
    while (size < static_cast<std::size_t>(in_use)) size *= 2;
    if (size <= ring.size()) return;
    ring.resize(size);
    mask = static_cast<int>(size) - 1;
  }

  TwofoldSum &operator[](int i) { return ring[i & mask]; }

  /* Add the sum to `to` and reset it to zero. */
  void give(int i, double *to)
  {
    TwofoldSum &sum = ring[i & mask];
    for (int d = 0; d < 3; d++) to[d] += sum.high[d] + sum.low[d];
    sum = TwofoldSum{};
  }

  double bytes() const { return static_cast<double>(ring.capacity()) * sizeof(TwofoldSum); }

 private:
  std::vector<TwofoldSum> ring;
  int mask = 0;
};

}    // namespace granwave

#endif
