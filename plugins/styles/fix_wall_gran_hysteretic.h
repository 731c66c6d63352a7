// SPDX-License-Identifier: GPL-2.0-only
/* Fix wall/gran/hysteretic: plane walls normal to an axis, with the contact laws and the lasting dents of pair style
   gran/hysteretic, with friction, and with the support of a plane that can move (support.h).

   fix ID group wall/gran/hysteretic xplane|yplane|zplane LO HI law ... [friction MU] [support ...]
       (law_arguments.h, support.h; LO, HI a coordinate or NULL)

   One material: a rigid wall. Two: sphere and wall. A dent belongs to its place on the wall: a sphere that has lifted
   off and lands further away than the radius of the contact circle at the dent starts anew. */

#ifndef LMP_FIX_WALL_GRAN_HYSTERETIC_H
#define LMP_FIX_WALL_GRAN_HYSTERETIC_H

#include "../laws/contact_law.h"
#include "../laws/exact_sum.h"
#include "fix.h"
#include "../laws/support.h"
#include "../laws/tangential.h"

#include <memory>
#include <vector>

namespace LAMMPS_NS {

class FixWallGranHysteretic : public Fix {
 public:
  static constexpr const char *STYLE = "wall/gran/hysteretic";

  FixWallGranHysteretic(LAMMPS *, int, char **);
  ~FixWallGranHysteretic() override;

  int setmask() override;
  void init() override;
  void reset_dt() override;
  void setup(int) override;
  void min_setup(int) override;
  void initial_integrate(int) override;
  void post_force(int) override;
  void min_post_force(int) override;
  void final_integrate() override;
  double compute_scalar() override;
  double compute_vector(int) override;

  /* Give a sphere a dent from before the run where it is now, on the nearer of the two walls. */
  void set_dent(int i, double peak);
  /* Make all dents so far initial ones, and start totals anew. */
  void begin();
  /* Power of the forces on a plane that moves, and force^2 over mass: parts of them that are not of spheres. */
  void add_power(double &power, double &force_squared_over_mass) const
  {
    if (support) support->add_power(power, force_squared_over_mass);
  }

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  double memory_usage() override;

 private:
  // columns of array_atom, the output of a sphere
  enum {
    OVERLAP,
    FORCE,
    PEAK_OVERLAP,
    PEAK_FORCE,
    DISSIPATED,
    TIME_FIRST,
    TIME_PEAK,
    TIME_YIELD,
    TANGENTIAL,
    FRICTION_LOSS,
    INITIAL,
    N_REPORTED
  };

  struct Side {    // a sphere's dent on one of the walls; all doubles, as which it travels
    double dent = 0.0, place[2] = {}, lost_before = 0.0, touching = 0.0;
    double initial = 0.0;    // the dent before the run, where beyond the elastic limit
  };
  static constexpr int N_SIDE = sizeof(Side) / sizeof(double),
                       N_SPRING = sizeof(granwave::TangentialSpring) / sizeof(double);

  struct Contact {    // of a sphere with a wall, now
    double force;
    double stiffness;    // the steepest that the force can fall or rise with the overlap; with a support only
    double circle_sq;    // radius of the contact circle, squared; with friction only
  };

  void evaluate();
  double level(int side) const;
  double depth(int i, int side) const;
  Contact compute_normal(int i, int side, double overlap, double now);
  void compute_tangential(int i, int side, double overlap, const Contact &);
  double minimum_image(int along, double distance) const;
  double *extra(int i, int side) { return extras.data() + (4 * static_cast<std::size_t>(i) + side) * n_extra(); }
  double *initial_extra(int i, int side) { return extra(i, 2 + side); }
  granwave::LawHistory law_history(int i, int side) { return {sides[2 * i + side].dent, extra(i, side)}; }
  double lost(int i, int side, const granwave::ScaledLaw &);
  void report_dents(int i);
  void push_support();
  void check_timestep(double contacts) const;
  void tally();
  int n_extra() const { return law.entry().n_extra; }
  int n_state() const { return N_REPORTED + 2 * N_SIDE + (friction > 0.0 ? 2 * N_SPRING : 0) + 4 * n_extra(); }

  int axis = 2;
  double plane[2];    // low and high side, infinite when absent; where they are at rest
  granwave::ContactLaw law;
  double friction = 0.0;
  granwave::TangentialModel tangential_model = granwave::TangentialModel::MINDLIN_RESCALE;
  std::unique_ptr<granwave::Support> support;    // of the one plane, if it can move
  int moving = 0;                                // which one

  std::vector<char> near;     // 0: the sphere touched no wall at the last evaluation, and is not new here
  std::vector<Side> sides;    // two for each sphere: low and high wall
  std::vector<granwave::TangentialSpring> springs;    // likewise, if there is friction
  std::vector<double> extras;    // history of the law beyond the dent: low and high wall now, the same before the run

  double wall_force[3];                     // of this processor's spheres on the wall
  granwave::ExactSum pressed, stiffness;    // force and stiffness of this processor's contacts with a moving plane
  double contact_stiffness = 0.0;           // of all
  bigint tallied = -1;
  enum { STORED, DISSIPATED_SUM, YIELDED, BEYOND_LAW, TANGENTIAL_STORED, FRICTION_LOSS_SUM, N_TOTALS };
  double totals[N_TOTALS];    // all processors
  int extensive[15] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 1, 1, 1, 1};
};

}    // namespace LAMMPS_NS

#endif
