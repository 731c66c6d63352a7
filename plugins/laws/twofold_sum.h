// SPDX-License-Identifier: GPL-2.0-only
/* Sums of forces or torques on spheres in twice the precision of a double. No LAMMPS types.

   The order in which the forces on a sphere are summed is that of the neighbor list, which depends on the number of
   processors. With twice the precision the rounded sum is the same in any order: runs are bitwise reproducible on any number
   of processors. */

#ifndef GRANWAVE_TWOFOLD_SUM_H
#define GRANWAVE_TWOFOLD_SUM_H

#include "components.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace granwave {

template <class Vector> struct alignas(2 * sizeof(Vector)) TwofoldSum {
  using Mask = decltype(Vector{} == Vector{});

  Vector high = {}, low = {};

  void add(const Vector &term)
  {
    const Vector total = high + term, rounded = total - high;
    low += (high - (total - rounded)) + (term - rounded);    // rounding error of the addition (Knuth)
    high = total;
  }

  /* Take the values of another sum where the mask is set. */
  void replace(const Mask &mask, const TwofoldSum &by)
  {
    high = mask ? by.high : high;
    low = mask ? by.low : low;
  }

  /* Add the sum to vectors of three components, and reset it to zero. */
  template <int N> void give(double *const (&to)[N])
  {
    const Vector sum = high + low;
    for (int n = 0; n < N; n++)
      for (int d = 0; d < 3; d++) to[n][d] += sum[4 * n + d];
    high = low = Vector{};
  }
};

/* One sum per sphere. With an ordered list only the sums between a row and its farthest partner are in use at a time, and a
   ring buffer of that size stays in the cache. All others are zero. */
template <class Vector> class TwofoldSums {
 public:
  using Sum = TwofoldSum<Vector>;

  void reserve(int in_use)
  {
    if (in_use > static_cast<int>(ring.size())) ring.resize(in_use);
  }

  /* The sums of the spheres from `first` on, as many as were reserved. */
  class Window {
   public:
    Window(Sum *ring, int size, int first) : ring_(ring), size_(size), start_(first - first % size) {}
    Sum &operator[](int i) const
    {
      const int place = i - start_;
      return ring_[place < size_ ? place : place - size_];
    }

   private:
    Sum *ring_;
    int size_, start_;    // sphere of the first place of the ring
  };
  Window from(int first) { return {ring.data(), static_cast<int>(ring.size()), first}; }

  double bytes() const { return static_cast<double>(ring.capacity()) * sizeof(Sum); }

 private:
  std::vector<Sum> ring;
};

}    // namespace granwave

#endif
