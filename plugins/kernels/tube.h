// SPDX-License-Identifier: GPL-2.0-only
/* Tube around z, and spheres in it. No LAMMPS types. */

#ifndef GRANWAVE_TUBE_H
#define GRANWAVE_TUBE_H

#include "../laws/cylinders.h"
#include "curved_wall.h"

#include <cmath>
#include <cstdio>
#include <string>
#include <unordered_map>

namespace granwave {

/* Rigid or elastic tube around the z axis: overlap, direction, and stiffness of the elliptic contacts of spheres in it. */
class Tube : public CurvedWall {
 public:
  explicit Tube(double radius) : radius_(radius), name_("tube of radius " + short_text(radius)) {}

  double circumference() const override { return 2.0 * PI * radius_; }
  bool holds(double radius) const override { return radius < radius_; }
  const char *name() const override { return name_.c_str(); }

  double overlap(const double *x, double radius) override { return from_axis(x) + radius - radius_; }

  /* Unit normal at a sphere, into the tube; zero on the axis, where no sphere touches the tube. */
  void inward(const double *x, double normal[3]) override
  {
    const double distance = from_axis(x);
    normal[0] = distance > 0.0 ? -x[0] / distance : 0.0;
    normal[1] = distance > 0.0 ? -x[1] / distance : 0.0;
    normal[2] = 0.0;
  }

  /* Location of a sphere along the tube: arc and z. */
  void place(const double *x, double found[3]) override
  {
    found[0] = radius_ * std::atan2(x[1], x[0]);
    found[1] = x[2];
    found[2] = 0.0;
  }

  /* Resolve a force at a sphere into components outward, around and along the tube. */
  void components(const double *x, double force[3]) override
  {
    double normal[3];
    inward(x, normal);
    const double outward = -(force[0] * normal[0] + force[1] * normal[1]);
    force[1] = force[0] * normal[1] - force[1] * normal[0];
    force[0] = outward;
  }

  /* Radius of the sphere whose stiffness on a plane equals that of a sphere of this radius in the tube; unchanged for a
     sphere that does not fit. */
  double effective_radius(double radius) override
  {
    if (!(radius > 0.0 && holds(radius))) return radius;
    const auto [known, fresh] = found_.try_emplace(radius, 0.0);
    if (fresh) known->second = elliptic_radius(1.0 / radius, 1.0 / radius - 1.0 / radius_);
    return known->second;
  }

 private:
  double radius_;
  std::string name_;
  std::unordered_map<double, double> found_;    // cached by radius of the spheres

  static std::string short_text(double value)
  {
    char text[32];
    std::snprintf(text, sizeof(text), "%.6g", value);
    return text;
  }

  static double from_axis(const double *x) { return std::sqrt(x[0] * x[0] + x[1] * x[1]); }
};

}    // namespace granwave

#endif
