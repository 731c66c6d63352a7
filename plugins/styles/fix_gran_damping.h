// SPDX-License-Identifier: GPL-2.0-only
/* Forces against the motion of atoms, and the dissipated energy.

   Fix gran/absorb: damping that lets waves run out of a system.

   fix ID group gran/absorb rate RATE                   force -m RATE v, torque -I RATE omega
   fix ID group gran/absorb rate RATE x|y|z FROM TO     RATE rises from 0 at FROM to its value at TO, as the square
   fix ID group gran/absorb impedance Z x|y|z           force -Z v along the axis

   The force of a timestep is that of the velocity at its end, which is found from the other forces, so that any rate is stable.

   Fix gran/holder: Coulomb friction of the holder that a row of spheres lies in.

   fix ID group gran/holder x|y|z FRICTION ACCELERATION

   Each atom is held back along the axis by at most FRICTION times its mass times ACCELERATION. The force of a timestep is the
   one that would bring the atom to rest within it, as far as this limit allows: an atom that the other forces cannot move
   stays where it is, exactly, and no small velocity has to be chosen below which friction fades. */

#ifdef FIX_CLASS
// clang-format off
FixStyle(gran/absorb,FixGranAbsorb);
FixStyle(gran/holder,FixGranHolder);
// clang-format on
#else

#ifndef LMP_FIX_GRAN_DAMPING_H
#define LMP_FIX_GRAN_DAMPING_H

#include "../kernels/exact_sum.h"
#include "fix.h"

namespace LAMMPS_NS {

class FixGranDamping : public Fix {
 public:
  FixGranDamping(LAMMPS *, int, char **);

  int setmask() override { return FixConst::POST_FORCE; }
  void init() override;
  void setup(int) override { power = total_power(0.0); }
  void post_force(int) override;
  double compute_scalar() override { return taken; }
  void write_restart(FILE *) override;
  void restart(char *) override;

 protected:
  /* Set the axis from its name. */
  void set_axis(const std::string &name, const char *usage);
  /* Add the forces to those of the atoms, and the power that they dissipate to the sum. `until_end` is the time from the
     present velocities to those of the instant of the forces. */
  virtual void add_forces(double until_end, granwave::ExactSum &power) = 0;

  int axis = 2;

 private:
  double total_power(double until_end);

  double taken = 0.0;    // energy so far
  double power = 0.0;    // power dissipated at the end of the step
};

class FixGranAbsorb : public FixGranDamping {
 public:
  static constexpr const char *STYLE = "gran/absorb";

  FixGranAbsorb(LAMMPS *, int, char **);

 private:
  void add_forces(double until_end, granwave::ExactSum &power) override;
  double rate_at(const double *x) const;

  double rate = 0.0, impedance = 0.0;    // one of them is 0
  bool graded = false;
  double from = 0.0, to = 0.0;
};

class FixGranHolder : public FixGranDamping {
 public:
  static constexpr const char *STYLE = "gran/holder";

  FixGranHolder(LAMMPS *, int, char **);

  void init() override;

 private:
  void add_forces(double until_end, granwave::ExactSum &power) override;

  double friction = 0.0, acceleration = 0.0;
};

}    // namespace LAMMPS_NS

#endif

#endif
