// SPDX-License-Identifier: GPL-2.0-only
/* Fix gran/absorb: damping that lets waves run out of a system.

   fix ID group gran/absorb rate RATE                   force -m RATE v, torque -I RATE omega
   fix ID group gran/absorb rate RATE x|y|z FROM TO     RATE rises from 0 at FROM to its value at TO, as the square
   fix ID group gran/absorb impedance Z x|y|z           force -Z v along the axis

   The force of a timestep is that of the velocity at its end, which is found from the other forces, so that any rate is stable. */

#ifndef LMP_FIX_GRAN_ABSORB_H
#define LMP_FIX_GRAN_ABSORB_H

#include "fix.h"

namespace LAMMPS_NS {

class FixGranAbsorb : public Fix {
 public:
  static constexpr const char *STYLE = "gran/absorb";

  FixGranAbsorb(LAMMPS *, int, char **);

  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_force(int) override;
  double compute_scalar() override;
  void write_restart(FILE *) override;
  void restart(char *) override;

 private:
  double apply_damping(double until_end);
  double rate_at(const double *x) const;

  double rate = 0.0, impedance = 0.0;    // one of them is 0
  int axis = -1;
  bool graded = false;
  double from = 0.0, to = 0.0;
  double absorbed = 0.0;    // energy so far
  double power = 0.0;       // absorbed at the end of the step
};

}    // namespace LAMMPS_NS

#endif
