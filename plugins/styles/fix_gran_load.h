// SPDX-License-Identifier: GPL-2.0-only
/* Fix gran/load: force or prescribed displacement of a group, with its work and impulse.

   fix ID group gran/load DIRECTION force|displacement SHAPE NUMBERS ...    (USAGE in the source)

   DIRECTION is x, y, z or vector DX DY DZ, of any length but zero.

   The force of a step is the mean of the shape over the timestep centered at it, from its integral, so that the impulse of a pulse does
   not depend on the timestep. */

#ifdef FIX_CLASS
// clang-format off
FixStyle(gran/load,FixGranLoad);
// clang-format on
#else

#ifndef LMP_FIX_GRAN_LOAD_H
#define LMP_FIX_GRAN_LOAD_H

#include "../laws/load_shape.h"
#include "fix.h"

#include <array>

namespace LAMMPS_NS {

class FixGranLoad : public Fix {
 public:
  static constexpr const char *STYLE = "gran/load";

  FixGranLoad(LAMMPS *, int, char **);

  int setmask() override
  {
    return FixConst::POST_NEIGHBOR |
           (moves ? FixConst::INITIAL_INTEGRATE | FixConst::FINAL_INTEGRATE : FixConst::POST_FORCE);
  }
  void init() override;
  void setup(int) override;
  void post_neighbor() override;
  void reset_dt() override;
  void initial_integrate(int) override;
  void post_force(int) override;
  void final_integrate() override;
  double compute_scalar() override { return totals()[WORK]; }
  double compute_vector(int) override;
  void write_restart(FILE *) override;
  void restart(char *) override;

 private:
  enum { WORK, IMPULSE, DISPLACEMENT, FORCE, N_TOTALS };
  static constexpr int N_STATE = 2 + N_TOTALS - 1;    // numbers in restart files: started, moves, totals

  int read_direction(int narg, char **arg);
  void read_table(const char *file);
  void count_atoms();
  void keep_motion(double lost_mass, double speed);
  void subtract_foreign_motion();
  void apply_force(double whole);
  void set_velocity(double speed);
  double along(const double *vector) const { return way[0] * vector[0] + way[1] * vector[1] + way[2] * vector[2]; }
  /* Add a component along the direction; perpendicular components are unchanged. */
  void add_along(double *vector, double size) const
  {
    for (int k = 0; k < 3; k++)
      if (way[k] != 0.0) vector[k] += size * way[k];
  }
  double force_on_group() const;
  double half_kick_work(double dt) const;
  std::array<double, N_TOTALS> totals() const;

  class FixGranTimestep *stepper = nullptr;       // which sets the clock, if there is one
  std::array<double, 3> way = {0.0, 0.0, 1.0};    // direction of the load, a unit vector
  bool moves = false;                             // prescribed displacement
  granwave::LoadShape shape;
  double atoms = 0.0, mass = 0.0;    // number of atoms and mass of the group; atoms may be lost
  double atoms_before = 0.0;         // number at the last step
  bool started = false;
  double stepped = 0.0;    // timestep over which the force is averaged
  // part of this processor in the totals so far; after a restart the first processor has the totals
  double total[N_TOTALS - 1] = {};
  double force = 0.0;         // force on the group, from the shape
  double resistance = 0.0;    // force on the atoms of this processor, before the step
  double place = 0.0, moved = 0.0,
         velocity = 0.0;    // present values of the prescribed motion, and displacement in this step
  int extensive[N_TOTALS - 1] = {1, 1, 0};
};

}    // namespace LAMMPS_NS

#endif

#endif
