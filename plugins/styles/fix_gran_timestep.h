// SPDX-License-Identifier: GPL-2.0-only
/* Fix gran/timestep: a timestep that follows the error of the energy balance.

   fix ID group gran/timestep N TOLERANCE ENERGY [first M] [until T] [balance v_NAME K]

   The step counter counts ticks, each one `timestep` long: a step is 1, 2, 4 ... N of them, so that all output falls on
   exact times. Velocity Verlet adds 1 to the counter before each step; the fix adds the rest beforehand, at the end of the
   step before, once all output of that step is written. */

#ifdef FIX_CLASS
// clang-format off
FixStyle(gran/timestep,FixGranTimestep);
// clang-format on
#else

#ifndef LMP_FIX_GRAN_TIMESTEP_H
#define LMP_FIX_GRAN_TIMESTEP_H

#include "../kernels/step_controller.h"
#include "fix_gran_cylinder.h"

#include <string>

namespace LAMMPS_NS {

class FixGranTimestep : public Fix {
 public:
  static constexpr const char *STYLE = "gran/timestep";

  FixGranTimestep(LAMMPS *, int, char **);
  ~FixGranTimestep() override;

  int setmask() override { return FixConst::INITIAL_INTEGRATE | FixConst::END_OF_STEP | FixConst::POST_RUN; }
  void init() override;
  void setup(int) override;
  void initial_integrate(int) override;
  void end_of_step() override;
  void post_run() override;
  double compute_vector(int n) override { return reported[n]; }
  void write_restart(FILE *) override;
  void restart(char *) override;

  /* Set the step counter for the step that begins, in a run's first step; others call it before they read the clock. */
  void begin_step();

 private:
  struct Sums {
    double p = 0.0, q = 0.0;    // power of the forces times tick, force^2/mass times tick^2: energies
  };

  double value_of(const std::string &variable, bigint next) const;
  void read_energy();
  Sums sums() const;
  void bound_step();
  bigint next_due() const;
  void refuse_fixes_that_count_steps() const;
  void refuse_variables_that_count_steps() const;
  bool fits(std::int64_t ticks, bigint due) const;
  bool tallied(bigint step) const;
  void take(std::int64_t ticks);
  void set_clock();
  void report();

  double tick = 0.0;
  double origin = 0.0;    // clock at step 0
  double tolerance;
  int integrated = 0;    // bits of the groups whose spheres move with the forces on them
  std::string energy_name;
  double energy = 0.0;
  std::string balance_name;
  bigint balance_every = 0;
  std::int64_t longest, first = 1, taken = 1;    // ticks: largest number, of the first step, of the present step
  double bound = 1.0;                            // ticks, limited by possible collisions
  double until = -1.0;                           // time up to which no step is longer than the first
  granwave::StepController controller;
  std::int64_t shortest_taken = 0, longest_taken = 0, n_steps = 0;
  double s = 0.0;
  Sums last;
  double reported[5] = {};    // output: constant during a step, and unchanged when a run is continued from a restart file
  bigint reached = 0;         // step counter when the last step ended
  bool pending = false;       // the counter is to be set as the next step begins
  int rotates = 0;            // bits of the groups whose spheres rotate with the torques on them
  std::shared_ptr<const granwave::Cylinders> cylinders;
  bigint n_atoms = 0;                                        // number of atoms at the end of the last step
  std::vector<const Fix *> others;                           // fixes that act in some steps
  std::vector<const Fix *> rebuilders;                       // fixes that request new neighbor lists at some step
  std::vector<const class FixWallGranHysteretic *> walls;    // that may move
};

}    // namespace LAMMPS_NS

#endif

#endif
