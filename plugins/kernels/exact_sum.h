// SPDX-License-Identifier: GPL-2.0-only
/* Exact sum of doubles, bitwise identical for any order of the terms and on any number of processors. No LAMMPS types. The sum
   is stored in bins of 32 bits, integers that are added without rounding; the bins of all processors are summed (MPI_SUM of
   data()). Parts of a term below 2^-256 are truncated; a term beyond about 2^180 makes the sum NaN. */

#ifndef GRANWAVE_EXACT_SUM_H
#define GRANWAVE_EXACT_SUM_H

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace granwave {

class ExactSum {
 public:
  static constexpr int SIZE = 16;    // the last bin counts terms that are too large, infinite or NaN

  void add(double term)
  {
    std::uint64_t bits;
    std::memcpy(&bits, &term, sizeof(bits));
    const int field = static_cast<int>(bits >> 52 & 0x7ff);
    if (field == 0) return;    // zero, or far below the smallest bin
    // |term| = mantissa 2^(field - 1075), rewritten below as mantissa 2^(LOWEST + place)
    std::uint64_t mantissa = (bits & ((std::uint64_t(1) << 52) - 1)) | std::uint64_t(1) << 52;
    int place = field - 1075 - LOWEST;
    if (place < 0) {
      mantissa = place > -64 ? mantissa >> -place : 0;
      place = 0;
    }
    const int k = place / WIDTH;
    if (k + 3 >= SIZE) {
      bins_[SIZE - 1]++;
      return;
    }
    const std::uint64_t shifted = mantissa << place % WIDTH, beyond = (mantissa >> WIDTH) >> (WIDTH - place % WIDTH);
    const std::int64_t sign = bits >> 63 ? -1 : 1;
    bins_[k] += sign * static_cast<std::int64_t>(shifted & 0xffffffff);
    bins_[k + 1] += sign * static_cast<std::int64_t>(shifted >> WIDTH);
    bins_[k + 2] += sign * static_cast<std::int64_t>(beyond);
  }

  double value() const
  {
    if (bins_[SIZE - 1] != 0) return std::numeric_limits<double>::quiet_NaN();
    double sum = 0.0;
    for (int k = SIZE - 2; k >= 0; k--) sum += std::ldexp(static_cast<double>(bins_[k]), weight(k));
    return sum;
  }

  std::int64_t *data() { return bins_; }

 private:
  static constexpr int WIDTH = 32, LOWEST = -256;
  static int weight(int k) { return LOWEST + k * WIDTH; }

  std::int64_t bins_[SIZE] = {};
};

}    // namespace granwave

#endif
