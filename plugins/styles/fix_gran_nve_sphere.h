// SPDX-License-Identifier: GPL-2.0-only
/* Fix gran/nve/sphere: velocity Verlet with rotation as in fix nve/sphere, but skipping blocks of spheres at rest.

   fix ID group gran/nve/sphere

   An angular velocity changes with its torque only, for spheres have no orientation: blocks without torque are passed over, whether
   their spheres turn or not. Numbers are those of fix nve/sphere. */

#ifdef FIX_CLASS
// clang-format off
FixStyle(gran/nve/sphere,FixGranNVESphere);
// clang-format on
#else

#ifndef LMP_FIX_GRAN_NVE_SPHERE_H
#define LMP_FIX_GRAN_NVE_SPHERE_H

#include "fix_gran_nve.h"

namespace LAMMPS_NS {

class FixGranNVESphere : public FixGranNVE {
 public:
  static constexpr const char *STYLE = "gran/nve/sphere";

  FixGranNVESphere(LAMMPS *, int, char **);

  void init() override;
  void initial_integrate(int) override;
  void final_integrate() override;

 private:
  void require_radii() const;
  void turn() const;
};

}    // namespace LAMMPS_NS

#endif
#endif
