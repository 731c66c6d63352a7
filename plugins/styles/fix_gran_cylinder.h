// SPDX-License-Identifier: GPL-2.0-only
/* Fix gran/cylinder: types of atoms that are cylinders, for pair style gran/hysteretic and fix wall/gran/hysteretic.

   fix ID group gran/cylinder TYPE LENGTH AX AY AZ [TYPE LENGTH AX AY AZ ...] [line half-space|plane-strain]

   The radius of a cylinder is that of its atom. Its axis is fixed in space, and it can turn about this axis only, with the
   moment of inertia m R^2/2: the fix projects its torque on the axis, and scales it for fix nve/sphere, which reckons with
   that of a sphere. */

#ifdef FIX_CLASS
// clang-format off
FixStyle(gran/cylinder,FixGranCylinder);
// clang-format on
#else

#ifndef LMP_FIX_GRAN_CYLINDER_H
#define LMP_FIX_GRAN_CYLINDER_H

#include "../laws/cylinders.h"
#include "fix.h"

#include <memory>
#include <vector>

namespace granwave {

/* Cylinders by type, from 1; shared with the styles that use them, also after the fix is deleted. */
class Cylinders {
 public:
  explicit Cylinders(int types) : shapes(types + 1) {}

  const Cylinder &shape(int type) const { return shapes[type]; }

  std::vector<Cylinder> shapes;
  bool plane_strain = false;    // true if parallel cylinders touch in plane strain, false if as half-spaces
};

}    // namespace granwave

namespace LAMMPS_NS {

class FixGranCylinder : public Fix {
 public:
  static constexpr const char *STYLE = "gran/cylinder";
  static constexpr double INERTIA = 1.25;    // moment of inertia / that of a sphere of the same mass and radius

  FixGranCylinder(LAMMPS *, int, char **);

  int setmask() override { return FixConst::POST_FORCE; }
  void init() override;
  void setup(int) override;
  void post_force(int) override;
  double compute_scalar() override;
  void write_restart(FILE *) override;
  void restart(char *) override;

  /* The cylinders of the fix of this style; null if there is no such fix and all particles are spheres. */
  static std::shared_ptr<const granwave::Cylinders> find(LAMMPS *);

 private:
  std::shared_ptr<granwave::Cylinders> cylinders;
};

}    // namespace LAMMPS_NS

#endif

#endif
