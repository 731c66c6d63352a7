// SPDX-License-Identifier: GPL-2.0-only
/* Cylinders with an axis that is fixed in space: contacts with spheres and with each other, and their curvatures. No
   LAMMPS types.

   A sphere touches the side of a cylinder in a point, as two cylinders that cross do; parallel cylinders touch along a line.
   The overlap is the sum of the radii minus the distance: of the center from the axis, or of the two axes. The ends of a
   cylinder do not touch anything: there is no contact beyond them.

   The area of a Hertzian contact of bodies with unlike curvatures is an ellipse.
   With the relative principal curvatures c1 <= c2 (sums of 1/R of both bodies in the two principal planes), m = e^2 of the
   ellipse is the root of

       [E(m)/(1 - m) - K(m)] / [K(m) - E(m)] = c2/c1           K, E: complete elliptic integrals of the parameter m

   and the contact is as stiff as that of a sphere of radius

       R = (pi/2)^2 (K(m) - E(m)) / (m (c1/2) K(m)^3)          F = 4/3 E* sqrt(R) alpha^1.5

   on a plane (K. L. Johnson, Contact Mechanics, 1985, section 4.2). Equal curvatures give R = 1/c. */

#ifndef GRANWAVE_CYLINDERS_H
#define GRANWAVE_CYLINDERS_H

#include "material.h"

#include <algorithm>
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

/* Radius of the sphere with the same stiffness on a plane, from two positive relative curvatures. */
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

/* Shape of a body: a cylinder, or a sphere if the length is 0. */
struct Cylinder {
  double length = 0.0, axis[3] = {};    // unit vector

  bool is_sphere() const { return length == 0.0; }
  bool operator==(const Cylinder &other) const { return length == other.length && std::equal(axis, axis + 3, other.axis); }
};

/* Geometry of the contacts of two bodies, at least one of which is a cylinder. */
class CylinderPair {
 public:
  static constexpr double PARALLEL = 1e-9;        // sine of the largest angle of axes that count as parallel
  static constexpr double LEAST_ANGLE = 0.017;    // sine of the smallest angle at which crossed cylinders touch in a point

  struct Separation {
    double distance, normal[3];    // unit vector from the second body to the first
    double beyond;                 // distance of the place of contact from the end of a cylinder; negative between its ends
  };

  CylinderPair(const Cylinder &one, const Cylinder &other) : one_(one), other_(other)
  {
    const Cylinder &first = one.is_sphere() ? other : one;
    std::copy_n(first.axis, 3, axis_);
    half_ = 0.5 * (one.length + other.length);
    if (one.is_sphere() || other.is_sphere()) return;
    double across[3];
    for (int d = 0; d < 3; d++) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      across[d] = one.axis[e] * other.axis[f] - one.axis[f] * other.axis[e];
    }
    sine_ = std::sqrt(dot(across, across));
    if (sine_ <= PARALLEL) {
      length_ = std::min(one.length, other.length);
      return;
    }
    crossed_ = true;
    for (int d = 0; d < 3; d++) axis_[d] = across[d] / sine_;
  }

  bool parallel() const { return length_ > 0.0; }
  // length of the line of contact of parallel cylinders: length of the shorter one
  double length() const { return length_; }
  /* True if the contact ellipse of crossed cylinders is too long for a point contact. */
  bool nearly_parallel() const { return crossed_ && sine_ < LEAST_ANGLE; }

  /* Separation of two bodies from the vector between their centers, from the second to the first. */
  Separation separation(const double del[3]) const
  {
    Separation found{};
    const double along = dot(del, axis_);
    if (crossed_) {
      found.distance = std::fabs(along);
      for (int d = 0; d < 3; d++) found.normal[d] = along < 0.0 ? -axis_[d] : axis_[d];
      const double a = dot(del, one_.axis), b = dot(del, other_.axis), c = dot(one_.axis, other_.axis);
      const double first = (c * b - a) / (sine_ * sine_), second = b + c * first;    // nearest points, along the axes
      found.beyond = std::max(std::fabs(first) - 0.5 * one_.length, std::fabs(second) - 0.5 * other_.length);
      return found;
    }
    for (int d = 0; d < 3; d++) found.normal[d] = del[d] - along * axis_[d];
    found.distance = std::sqrt(dot(found.normal, found.normal));
    for (int d = 0; d < 3; d++) found.normal[d] /= found.distance;
    found.beyond = std::fabs(along) - half_;
    return found;
  }

  /* Radius of the sphere with the stiffness of the point contact on a plane; for a line, from both curvatures. */
  double effective_radius(double r1, double r2) const
  {
    if (parallel()) return granwave::effective_radius(r1, r2);
    const double c1 = 1.0 / r1, c2 = 1.0 / r2;
    if (!crossed_) return elliptic_radius(one_.is_sphere() ? c1 : c2, c1 + c2);
    const double sum = c1 + c2, root = std::sqrt(std::max(sum * sum - 4.0 * c1 * c2 * sine_ * sine_, 0.0));
    const double large = 0.5 * (sum + root);
    return elliptic_radius(c1 * c2 * sine_ * sine_ / large, large);
  }

  /* Largest distance of the centers of two bodies whose axes, or center and axis, are this far apart between the ends. */
  double center_distance(double distance) const { return std::sqrt(distance * distance + half_ * half_); }

 private:
  Cylinder one_, other_;
  double axis_[3], half_, sine_ = 0.0, length_ = 0.0;    // axis of the cylinder, or common normal of crossed cylinders
  bool crossed_ = false;

  static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
};

}    // namespace granwave

#endif
