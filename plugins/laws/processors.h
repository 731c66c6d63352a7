// SPDX-License-Identifier: GPL-2.0-only
/* Functions compiled for several instruction sets; the best available one is selected at run time. Results are bitwise
   identical, since nothing is contracted or reordered (CMakeLists.txt). With GRANWAVE_ONE_PROCESSOR they are compiled once,
   for the processor that the compiler is told. */

#ifndef GRANWAVE_PROCESSORS_H
#define GRANWAVE_PROCESSORS_H

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__gnu_linux__) &&                            \
    !defined(GRANWAVE_ONE_PROCESSOR)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#define FOR_FOUR_DOUBLES __attribute__((target_clones("avx2", "default")))    // where wider ones are of no use
// a function written for this instruction set, and the one in its place for all others
#define FOR_AVX2 __attribute__((target("avx2")))
#define FOR_OTHERS __attribute__((target("default")))
#else
#define FOR_EACH_PROCESSOR
#define FOR_FOUR_DOUBLES
#define FOR_OTHERS
#endif

#endif
