// SPDX-License-Identifier: GPL-2.0-only
/* Vectors of four and eight doubles, which the compiler computes with at once (extension of GCC and Clang). No LAMMPS types.

   The arithmetic of a vector is that of its elements, so that results are the same on all processors. */

#ifndef GRANWAVE_COMPONENTS_H
#define GRANWAVE_COMPONENTS_H

#include <cstring>

namespace granwave {

/* Three components and one more. */
typedef double Components __attribute__((vector_size(4 * sizeof(double))));
/* Two of these, such as a force and a torque. */
typedef double TwoComponents __attribute__((vector_size(8 * sizeof(double))));
/* Result of a comparison: 0 or -1 in each element. */
typedef long long ComponentMask __attribute__((vector_size(4 * sizeof(long long))));

/* Four doubles from any address. */
inline void read(Components &to, const double *from) { std::memcpy(&to, from, sizeof(to)); }
inline void write(double *to, const Components &from) { std::memcpy(to, &from, sizeof(from)); }

/* Turn four vectors into the four of their first, second, third and fourth elements. */
inline void transpose(const Components (&in)[4], Components (&out)[4])
{
#if defined(__clang__)
  for (int a = 0; a < 4; a++)
    for (int b = 0; b < 4; b++) out[a][b] = in[b][a];
#else
  const ComponentMask low = {0, 4, 2, 6}, high = {1, 5, 3, 7}, first = {0, 1, 4, 5}, second = {2, 3, 6, 7};
  const Components a = __builtin_shuffle(in[0], in[1], low), b = __builtin_shuffle(in[0], in[1], high);
  const Components c = __builtin_shuffle(in[2], in[3], low), d = __builtin_shuffle(in[2], in[3], high);
  out[0] = __builtin_shuffle(a, c, first);
  out[1] = __builtin_shuffle(b, d, first);
  out[2] = __builtin_shuffle(a, c, second);
  out[3] = __builtin_shuffle(b, d, second);
#endif
}

}    // namespace granwave

#endif
