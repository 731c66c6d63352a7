// SPDX-License-Identifier: GPL-2.0-only
/* Rigid or elastic tube around the z axis, and spheres in it: overlap, direction, and stiffness of their elliptic contacts
   (elliptic_contact.h). No LAMMPS types. */

#ifndef GRANWAVE_TUBE_H
#define GRANWAVE_TUBE_H

#include "elliptic_contact.h"

#include <cmath>
#include <unordered_map>

namespace granwave {

class Tube {
 public:
  explicit Tube(double radius) : radius_(radius) {}

  double circumference() const { return 2.0 * PI * radius_; }
  bool holds(double radius) const { return radius < radius_; }
  double radius() const { return radius_; }

  double overlap(const double *x, double radius) const { return from_axis(x) + radius - radius_; }

  /* Unit normal at a sphere, into the tube; zero on the axis, which no sphere that touches the tube reaches. */
  void inward(const double *x, double normal[3]) const
  {
    const double distance = from_axis(x);
    normal[0] = distance > 0.0 ? -x[0] / distance : 0.0;
    normal[1] = distance > 0.0 ? -x[1] / distance : 0.0;
    normal[2] = 0.0;
  }

  /* Location of a sphere along the tube: arc and z. */
  void place(const double *x, double found[2]) const
  {
    found[0] = radius_ * std::atan2(x[1], x[0]);
    found[1] = x[2];
  }

  /* Components outward, around and along the tube of a force at a sphere. */
  void cylindrical(const double *x, const double force[3], double found[3]) const
  {
    double normal[3];
    inward(x, normal);
    found[0] = -(force[0] * normal[0] + force[1] * normal[1]);
    found[1] = force[0] * normal[1] - force[1] * normal[0];
    found[2] = force[2];
  }

  /* Radius of the sphere that is as stiff on a plane as one of this radius in the tube; of one that does not fit its own. */
  double effective_radius(double radius)
  {
    if (radius == last_radius_) return last_;
    if (!(radius > 0.0 && holds(radius))) return radius;
    const auto known = found_.find(radius);
    last_ = known != found_.end() ? known->second : elliptic_radius(1.0 / radius, 1.0 / radius - 1.0 / radius_);
    return found_[last_radius_ = radius] = last_;
  }

 private:
  double radius_;
  std::unordered_map<double, double> found_;    // by radius of the spheres
  double last_radius_ = 0.0, last_ = 0.0;       // of the sphere asked for last: neighbours are mostly alike

  static double from_axis(const double *x) { return std::sqrt(x[0] * x[0] + x[1] * x[1]); }
};

}    // namespace granwave

#endif
