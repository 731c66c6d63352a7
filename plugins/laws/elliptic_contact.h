// SPDX-License-Identifier: GPL-2.0-only
/* Hertzian contact of bodies with unlike curvatures, whose contact area is an ellipse. No LAMMPS types.

   With the relative principal curvatures c1 <= c2 (sums of 1/R of both bodies in the two principal planes), m = e^2 of the
   ellipse is the root of

       [E(m)/(1 - m) - K(m)] / [K(m) - E(m)] = c2/c1           K, E: complete elliptic integrals of the parameter m

   and the contact is as stiff as that of a sphere of radius

       R = (pi/2)^2 (K(m) - E(m)) / (m (c1/2) K(m)^3)          F = 4/3 E* sqrt(R) alpha^1.5

   on a plane (K. L. Johnson, Contact Mechanics, 1985, section 4.2). Equal curvatures give R = 1/c. */

#ifndef GRANWAVE_ELLIPTIC_CONTACT_H
#define GRANWAVE_ELLIPTIC_CONTACT_H

#include "material.h"

#include <cmath>

namespace granwave {

namespace elliptic {

/* Complete elliptic integrals by the arithmetic-geometric mean, in forms without cancellation. */
struct Integrals {
  double first;         // K
  double difference;    // (K - E)/m
  double weighted;      // (E - (1 - m) K)/m

  /* `complement` is sqrt(1 - m), above 0 and at most 1. The sum is that of 2^(n-1) c_n^2/m with c_n = (a - b)/2, from n = 1. */
  explicit Integrals(double complement)
  {
    double a = 0.5 * (1.0 + complement), b = std::sqrt(complement), c = 0.5 * (1.0 - complement);
    double term = 0.25 * (1.0 - complement) / (1.0 + complement), sum = term;
    while (c > 1e-17 * a) {
      const double mean = 0.5 * (a + b), next = 0.25 * c * c / mean;
      b = std::sqrt(a * b);
      a = mean;
      term *= 2.0 * next / (4.0 * mean);    // c_n^2 = c_(n-1)^2 c_n/(4 a_n)
      c = next;
      sum += term;
    }
    first = 0.5 * PI / a;
    difference = first * (0.5 + sum);
    weighted = first * (0.5 - sum);
  }
};

/* Ratio of the curvatures of an ellipse; it falls from infinity to 1 as the complement rises to 1. */
inline double curvature_ratio(double complement)
{
  const Integrals of(complement);
  return of.weighted / (complement * complement * of.difference);
}

}    // namespace elliptic

/* Radius of the sphere that is as stiff on a plane, from two positive relative curvatures. */
inline double elliptic_radius(double one, double other)
{
  const double least = std::fmin(one, other), ratio = std::fmax(one, other) / least;
  if (ratio == 1.0) return 1.0 / least;
  double low = 0.0, high = 1.0;    // of the complement
  for (int n = 0; n < 200; n++) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    (elliptic::curvature_ratio(middle) > ratio ? low : high) = middle;
  }
  const elliptic::Integrals of(0.5 * (low + high));
  return 0.25 * PI * PI * of.difference / (0.5 * least * of.first * of.first * of.first);
}

}    // namespace granwave

#endif
