// SPDX-License-Identifier: GPL-2.0-only
/* Fix gran/nve: velocity Verlet as in fix nve, but skipping blocks of atoms at rest.

   fix ID group gran/nve

   Atoms without velocity and force stay where they are: in a packing that waits for an impact, these are most of them. Numbers are
   those of fix nve. */

#ifdef FIX_CLASS
// clang-format off
FixStyle(gran/nve,FixGranNVE);
// clang-format on
#else

#ifndef LMP_FIX_GRAN_NVE_H
#define LMP_FIX_GRAN_NVE_H

#include "fix.h"

namespace LAMMPS_NS {

class FixGranNVE : public Fix {
 public:
  static constexpr const char *STYLE = "gran/nve";

  FixGranNVE(LAMMPS *, int, char **);

  int setmask() override { return FixConst::INITIAL_INTEGRATE | FixConst::FINAL_INTEGRATE; }
  void init() override;
  void reset_dt() override;
  void initial_integrate(int) override;
  void final_integrate() override;

 protected:
  double dtv = 0.0, dtf = 0.0;    // timestep, and half of it in units of velocity per acceleration (force / mass)

 private:
  template <bool MOVES> void integrate();
};

}    // namespace LAMMPS_NS

#endif
#endif
