// SPDX-License-Identifier: GPL-2.0-only
/* Functions that also run on graphics cards: GRANWAVE_KERNEL stands before each of them. A file that needs them there
   includes a header of Kokkos before those of this folder, as with GRAN_KERNEL_FN of LAMMPS's package GRANULAR. Without
   Kokkos the word is `inline`. Results are the same to the last bit if products and sums are not contracted (nvcc:
   -fmad=false). No LAMMPS types.

   Functions of the C++ library that compilers for cards do not have there are written out below.

   GRANWAVE_EXTENSIONS is defined where the compiler has the extensions of GCC and Clang: other compilers, and all with
   GRANWAVE_PLAIN, compile standard C++. */

#ifndef GRANWAVE_KERNEL_H
#define GRANWAVE_KERNEL_H

#ifdef KOKKOS_INLINE_FUNCTION
#define GRANWAVE_KERNEL KOKKOS_INLINE_FUNCTION
#else
#define GRANWAVE_KERNEL inline
#endif

#if defined(__GNUC__) && !defined(__NVCOMPILER) && !defined(GRANWAVE_PLAIN)
#define GRANWAVE_EXTENSIONS
#define ALWAYS_INLINE __attribute__((always_inline)) inline
#else
#define ALWAYS_INLINE inline
#endif

namespace granwave {

/* std::max and std::min of two numbers. */
GRANWAVE_KERNEL double larger(double a, double b) { return a < b ? b : a; }
GRANWAVE_KERNEL double smaller(double a, double b) { return b < a ? b : a; }

}    // namespace granwave

#endif
