// SPDX-License-Identifier: GPL-2.0-only
/* Fix gran/holder: Coulomb friction of the holder that a row of spheres lies in.

   fix ID group gran/holder x|y|z FRICTION ACCELERATION

   Each atom is held back along the axis by at most FRICTION times its mass times ACCELERATION. The force of a timestep is the
   one that would bring the atom to rest within it, as far as this limit allows: an atom that the other forces cannot move
   stays where it is, exactly, and no small velocity has to be chosen below which friction fades. */

#ifndef LMP_FIX_GRAN_HOLDER_H
#define LMP_FIX_GRAN_HOLDER_H

#include "fix.h"

namespace LAMMPS_NS {

class FixGranHolder : public Fix {
 public:
  static constexpr const char *STYLE = "gran/holder";

  FixGranHolder(LAMMPS *, int, char **);

  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_force(int) override;
  double compute_scalar() override;
  void write_restart(FILE *) override;
  void restart(char *) override;

 private:
  double apply_friction(double until_stop, double until_whole);

  int axis = 2;
  double friction = 0.0, acceleration = 0.0;
  double lost = 0.0;     // energy so far
  double power = 0.0;    // that the holder takes at the end of the step
};

}    // namespace LAMMPS_NS

#endif
