// SPDX-License-Identifier: GPL-2.0-only
/* Extensions of standard C++: functions compiled for several instruction sets, of which the best available set is selected
   at run time; groups of numbers in one register; prefetching; the lowest bit of a word. Results are bitwise identical with
   and without them, since nothing is contracted or reordered (CMakeLists.txt).

   With GRANWAVE_ONE_PROCESSOR functions are compiled once, for the processor that the compiler is told. Without
   GRANWAVE_EXTENSIONS (kernel.h) everything is standard C++. */

#ifndef GRANWAVE_PROCESSORS_H
#define GRANWAVE_PROCESSORS_H

#include "../laws/kernel.h"

#include <cstdint>

#if defined(GRANWAVE_EXTENSIONS) && defined(__x86_64__) && !defined(__clang__) && defined(__gnu_linux__) &&                 \
    !defined(GRANWAVE_ONE_PROCESSOR)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#define FOR_FOUR_DOUBLES __attribute__((target_clones("avx2", "default")))    // where wider ones are of no use
// a function written for this instruction set, and the one in its place for all others
#define FOR_AVX2 __attribute__((target("avx2")))
#define FOR_OTHERS __attribute__((target("default")))
#include <immintrin.h>
#else
#define FOR_EACH_PROCESSOR
#define FOR_FOUR_DOUBLES
#define FOR_OTHERS
#endif

#ifdef GRANWAVE_EXTENSIONS
#define FETCH_AHEAD(address) __builtin_prefetch(address)
#define FETCH_AHEAD_TO_WRITE(address) __builtin_prefetch(address, 1)
#else
#define FETCH_AHEAD(address) static_cast<void>(address)
#define FETCH_AHEAD_TO_WRITE(address) static_cast<void>(address)
#endif

namespace granwave {

#ifdef GRANWAVE_EXTENSIONS

typedef double TwoDoubles __attribute__((vector_size(2 * sizeof(double))));
typedef double FourDoubles __attribute__((vector_size(4 * sizeof(double))));
typedef std::int64_t FourWords __attribute__((vector_size(4 * sizeof(std::int64_t))));

/* Index of the lowest bit of a word that is not 0. */
inline int lowest_bit(std::uint64_t word) { return __builtin_ctzll(word); }

#else

/* Numbers that are added, multiplied and compared one by one, with the operators of the vector extension of GCC and Clang. */
template <class Number, int SIZE> struct Lanes {
  Number number[SIZE];

  Number operator[](int n) const { return number[n]; }
};

/* Return the lanes f(a[n], b[n]). */
template <class Result, class Number, int SIZE, class Function>
inline Lanes<Result, SIZE> lane_by_lane(const Lanes<Number, SIZE> &a, const Lanes<Number, SIZE> &b, const Function &f)
{
  Lanes<Result, SIZE> result{};
  for (int n = 0; n < SIZE; n++) result.number[n] = f(a[n], b[n]);
  return result;
}

template <class Number, int SIZE> inline Lanes<Number, SIZE> same_lanes(Number x)
{
  Lanes<Number, SIZE> result{};
  for (Number &number : result.number) number = x;
  return result;
}

using TwoDoubles = Lanes<double, 2>;
using FourDoubles = Lanes<double, 4>;
using FourWords = Lanes<std::int64_t, 4>;

template <int SIZE> using DoubleLanes = Lanes<double, SIZE>;
template <int SIZE> using WordLanes = Lanes<std::int64_t, SIZE>;

template <int SIZE> inline DoubleLanes<SIZE> operator+(const DoubleLanes<SIZE> &a, const DoubleLanes<SIZE> &b)
{
  return lane_by_lane<double>(a, b, [](double x, double y) { return x + y; });
}
template <int SIZE> inline DoubleLanes<SIZE> operator-(const DoubleLanes<SIZE> &a, const DoubleLanes<SIZE> &b)
{
  return lane_by_lane<double>(a, b, [](double x, double y) { return x - y; });
}
template <int SIZE> inline DoubleLanes<SIZE> operator*(const DoubleLanes<SIZE> &a, const DoubleLanes<SIZE> &b)
{
  return lane_by_lane<double>(a, b, [](double x, double y) { return x * y; });
}
template <int SIZE> inline DoubleLanes<SIZE> operator-(const DoubleLanes<SIZE> &a)
{
  return lane_by_lane<double>(a, a, [](double x, double) { return -x; });
}
template <int SIZE> inline DoubleLanes<SIZE> operator+(const DoubleLanes<SIZE> &a, double b)
{
  return a + same_lanes<double, SIZE>(b);
}
template <int SIZE> inline DoubleLanes<SIZE> operator*(const DoubleLanes<SIZE> &a, double b)
{
  return a * same_lanes<double, SIZE>(b);
}
template <int SIZE> inline DoubleLanes<SIZE> operator*(double a, const DoubleLanes<SIZE> &b)
{
  return same_lanes<double, SIZE>(a) * b;
}
template <int SIZE> inline DoubleLanes<SIZE> &operator+=(DoubleLanes<SIZE> &a, const DoubleLanes<SIZE> &b)
{
  return a = a + b;
}
// comparisons: all bits of a word are set where they hold
template <int SIZE> inline WordLanes<SIZE> operator>(const DoubleLanes<SIZE> &a, const DoubleLanes<SIZE> &b)
{
  return lane_by_lane<std::int64_t>(a, b, [](double x, double y) { return std::int64_t(x > y ? -1 : 0); });
}
template <int SIZE> inline WordLanes<SIZE> operator>=(const DoubleLanes<SIZE> &a, const DoubleLanes<SIZE> &b)
{
  return lane_by_lane<std::int64_t>(a, b, [](double x, double y) { return std::int64_t(x >= y ? -1 : 0); });
}
template <int SIZE> inline WordLanes<SIZE> operator&(const WordLanes<SIZE> &a, const WordLanes<SIZE> &b)
{
  return lane_by_lane<std::int64_t>(a, b, [](std::int64_t x, std::int64_t y) { return x & y; });
}
template <int SIZE> inline WordLanes<SIZE> operator|(const WordLanes<SIZE> &a, const WordLanes<SIZE> &b)
{
  return lane_by_lane<std::int64_t>(a, b, [](std::int64_t x, std::int64_t y) { return x | y; });
}
template <int SIZE> inline WordLanes<SIZE> &operator|=(WordLanes<SIZE> &a, const WordLanes<SIZE> &b) { return a = a | b; }
template <int SIZE> inline WordLanes<SIZE> operator~(const WordLanes<SIZE> &a)
{
  return lane_by_lane<std::int64_t>(a, a, [](std::int64_t x, std::int64_t) { return ~x; });
}
// without signs, so that a bit may be moved out
template <int SIZE> inline WordLanes<SIZE> operator<<(const WordLanes<SIZE> &a, int places)
{
  return lane_by_lane<std::int64_t>(
      a, a, [places](std::int64_t x, std::int64_t) { return static_cast<std::int64_t>(std::uint64_t(x) << places); });
}
template <int SIZE> inline WordLanes<SIZE> &operator<<=(WordLanes<SIZE> &a, int places) { return a = a << places; }
template <int SIZE> inline WordLanes<SIZE> &operator+=(WordLanes<SIZE> &a, const WordLanes<SIZE> &b)
{
  return a = lane_by_lane<std::int64_t>(a, b, [](std::int64_t x, std::int64_t y) {
           return static_cast<std::int64_t>(std::uint64_t(x) + std::uint64_t(y));
         });
}

/* Index of the lowest bit of a word that is not 0. */
inline int lowest_bit(std::uint64_t word)
{
  int index = 0;
  for (; (word & 1) == 0; word >>= 1) index++;
  return index;
}

#endif

}    // namespace granwave

#endif
