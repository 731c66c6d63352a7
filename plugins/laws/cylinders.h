// SPDX-License-Identifier: GPL-2.0-only
/* Cylinders with an axis that is fixed in space: where they touch spheres and each other, and with which curvatures. No LAMMPS
   types.

   A sphere touches the side of a cylinder in a point, as two cylinders that cross do; parallel cylinders touch along a line.
   The overlap is the sum of the radii minus the distance: of the center from the axis, or of the two axes. The ends of a
   cylinder do not touch anything: there is no contact beyond them. */

#ifndef GRANWAVE_CYLINDERS_H
#define GRANWAVE_CYLINDERS_H

#include "elliptic_contact.h"

#include <algorithm>
#include <cmath>

namespace granwave {

/* Shape of a body: a cylinder, or a sphere if the length is 0. */
struct Cylinder {
  double length = 0.0, axis[3] = {};    // unit vector

  bool is_sphere() const { return length == 0.0; }
  bool operator==(const Cylinder &other) const { return length == other.length && std::equal(axis, axis + 3, other.axis); }
};

/* Geometry of the contacts of two bodies, at least one of which is a cylinder. */
class CylinderPair {
 public:
  static constexpr double PARALLEL = 1e-9;        // sine of the angle of axes up to which they count as parallel
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
  double length() const { return length_; }    // of the line of contact of parallel cylinders: of the shorter one
  /* True if the contact of crossed cylinders is so long an ellipse that it is none. */
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
      const double first = (c * b - a) / (sine_ * sine_), second = b + c * first;    // of the nearest points, along the axes
      found.beyond = std::max(std::fabs(first) - 0.5 * one_.length, std::fabs(second) - 0.5 * other_.length);
      return found;
    }
    for (int d = 0; d < 3; d++) found.normal[d] = del[d] - along * axis_[d];
    found.distance = std::sqrt(dot(found.normal, found.normal));
    for (int d = 0; d < 3; d++) found.normal[d] /= found.distance;
    found.beyond = std::fabs(along) - half_;
    return found;
  }

  /* Radius of the sphere that is as stiff on a plane as a contact in a point; that of both curvatures for a line. */
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
  double axis_[3], half_, sine_ = 0.0, length_ = 0.0;    // axis: of the cylinder, or the common normal of crossed ones
  bool crossed_ = false;

  static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
};

}    // namespace granwave

#endif
