// SPDX-License-Identifier: GPL-2.0-only
/* Fix wall/gran/hysteretic: plane walls normal to an axis, a tube around z, a face of a region, or a patch of a surface of triangles, with the contact
   laws and the persistent dents of pair style gran/hysteretic, with friction, and with the support of a movable plane (support.h).

   fix ID group wall/gran/hysteretic xplane|yplane|zplane LO HI law ... [friction MU] [line half-space|plane-strain] [support ...]
       (law_arguments.h, support.h; LO, HI a coordinate or NULL)
   fix ID group wall/gran/hysteretic tube RADIUS law ... [friction MU]
   fix ID group wall/gran/hysteretic region ID FACE law ... [friction MU]    (region_wall.h)
   fix ID group wall/gran/hysteretic mesh FILE ANGLE PATCH law ... [friction MU]    (triangle_mesh.h)

   Types of fix gran/cylinder touch a plane that is parallel to their axis along a line, elastically (elastic_contact.h), and none
   that they stand on.

   With one material the wall is rigid; with two, the second is that of the wall. Dents are stored with their location on the
   wall: a sphere that has separated and touches the wall again starts a new contact if it is further from that location than
   the radius of the contact circle at the dent. */

#ifdef FIX_CLASS
// clang-format off
FixStyle(wall/gran/hysteretic,FixWallGranHysteretic);
// clang-format on
#else

#ifndef LMP_FIX_WALL_GRAN_HYSTERETIC_H
#define LMP_FIX_WALL_GRAN_HYSTERETIC_H

#include "../kernels/contact_step.h"
#include "../kernels/exact_sum.h"
#include "../kernels/front.h"
#include "../kernels/line_batch.h"
#include "../kernels/mesh_wall.h"
#include "../kernels/support.h"
#include "fix_gran_cylinder.h"
#include "moved_mass.h"
#include "region_wall.h"
#include "update.h"
#include "wall_history.h"

#include <map>

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
  void min_pre_exchange() override;
  void initial_integrate(int) override { support->advance(update->dt); }
  void setup_post_neighbor() override { post_neighbor(); }
  void post_neighbor() override
  {
    listed = false;
    if (has_dashpot()) masses.update();
  }
  void min_post_neighbor() override { listed = false; }
  void post_force(int) override { evaluate(); }
  void min_post_force(int) override;
  void final_integrate() override { support->finish(update->dt); }
  double compute_scalar() override;
  int modify_param(int, char **) override;
  double compute_vector(int) override;

  /* Set the initial dent of a sphere at its present position, on the nearer of the two walls. */
  void set_dent(int i, double peak);
  /* Set the complete history of the contact of a sphere with the nearer of the two walls. Returns false if the history of
     this wall differs. */
  bool set_contact(int i, const granwave::KnownContact &);
  /* Turn all dents so far into initial dents, and reset the totals. */
  void begin(bool keeps);
  /* Return the coefficient of friction. */
  void *extract(const char *, int &) override;
  /* Power of the forces on a movable plane, and force^2 / mass: the contributions other than those of spheres. */
  void add_power(double &power, double &force_squared_over_mass) const
  {
    if (support) support->add_power(power, force_squared_over_mass);
  }

  /* Add the magnitudes of the components of the forces of the walls on sphere i; of two planes at once the larger force. */
  void add_magnitudes(int i, double sums[3]);

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
  // columns of array_atom, the per-sphere output
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
    VISCOUS,
    N_REPORTED
  };

  using Side = granwave::WallSide;

  static constexpr double ROUNDING = 1e-12;    // relative to the radius: smaller overlaps are rounding errors of positions

  struct Contact {    // present contact of a sphere with a wall
    double force;
    double stiffness;    // largest slope of the force against the overlap, on loading or unloading; with a support only
    double circle;       // radius of the contact circle; with friction, resistance or cohesion only
    double pressing;     // normal force that limits friction
    double damping;      // coefficient of damping along the surface; below 0: a run is continued, or there is none
  };

  int read_wall(char **arg);
  void read_support(std::vector<std::string> &words);
  void list_spheres();
  bool meets_walls(int i) const;
  void part(int i);
  void evaluate();
  void keep_start();
  void return_to_start();
  double level(int side) const;
  double depth(int i, int side) const;
  void inward(int i, int side, double normal[3]) const;
  void place_of(int i, double place[3]) const;
  void init_cylinders();
  void admit_type(int type);
  bool is_line(int i) const;
  const granwave::ScaledLaw &scaled_law(int i);
  void compute_lines(const double at[2]);
  Contact compute_normal(int i, int side, double overlap, double now, std::size_t line);
  void compute_cohesion(int i, int side, double overlap, const granwave::ScaledLaw &, Contact &);
  bool joins(int i, int side, double overlap);
  bool has_dashpot() const { return loss.kind == granwave::LossKind::DASHPOT; }
  double effective_mass(int i, int side, double stiffness) const;
  void compute_viscous(int i, int side, double overlap, const granwave::ScaledLaw &, Contact &);
  void compute_tangential(int i, int side, double overlap, const Contact &);
  void advance_friction(int i, int side, double lever, const Contact &);
  void friction_force(int i, int side, double force[3]);
  void compute_resistance(int i, int side, const Contact &);
  void report_losses(int i);
  double distance_squared(const double from[3], const double to[3]) const;
  double *extra(int i, int side) { return histories.block(i, side); }
  double *initial_extra(int i, int side) { return histories.initial(i, side); }
  granwave::LawHistory law_history(int i, int side) { return {histories.side(i, side).dent, extra(i, side)}; }
  double approach(int i, int side) const;
  int nearer(int i) const { return depth(i, 0) > depth(i, 1) ? 0 : 1; }
  void require_dented(int i, double peak);
  void note_largest_force(int i, double force, double now);
  double lost(int i, int side, const granwave::ScaledLaw &);
  void report_dents(int i);
  void unpack_reported(int i, const double *values);
  static void reset_reported(double *reported);
  bool is_new(int i) const;
  void push_support();
  void check_timestep(double contacts) const;
  void tally();
  granwave::Step step() const { return {update->dt, update->whichflag == 1 && !update->setupflag}; }
  // histories at one of the walls
  granwave::Stored<granwave::CohesionHistory> sticking(int i, int side) { return has.cohesion_of(extra(i, side)); }
  granwave::Stored<granwave::ResistanceHistory> resisted(int i, int side) { return has.resistance_of(extra(i, side)); }
  double viscous_loss(int i, int side) { return has.viscous_loss(extra(i, side)); }
  int n_state() const { return N_REPORTED + granwave::Front::LEVELS + histories.size(); }

  int axis = 2;
  std::unique_ptr<granwave::CurvedWall> curved;    // curved wall instead of planes
  double plane[2];                                 // positions at rest of the lower and upper wall, infinite if absent
  granwave::ContactLaw law;
  granwave::Material body{}, wall{};                       // materials of the spheres and of the wall
  bool plane_strain = false;                               // of cylinders
  std::shared_ptr<const granwave::Cylinders> cylinders;    // null if there are none
  std::vector<char> stands;      // by type: 1 for cylinders on their end, which the wall does not touch
  std::vector<char> admitted;    // by type: 1 if cylinders of this type can be at the wall
  std::map<std::pair<int, double>, granwave::ElasticContact> lines;    // laws of cylinders, by type and radius
  bool has_lines = false;                                              // true if any of them touches along a line
  granwave::LineBatch line_batch{};
  std::vector<double> line_force, line_stiffness;    // two values for each of `spheres`, for those that touch along a line
  struct LastLaw {
    double radius = -1.0;
    granwave::ScaledLaw scaled;
  };
  std::vector<LastLaw> last_laws;    // by type
  double friction = 0.0;
  granwave::TangentialModel tangential_model = granwave::TangentialModel::MINDLIN_RESCALE;
  granwave::ContactMemory has;    // has.friction: friction or a resistance
  granwave::ResistanceModel resistance;
  granwave::ViscousLoss loss;
  granwave::MovedMass masses;                    // with a dashpot
  std::unique_ptr<granwave::Support> support;    // support of the plane, if it can move
  int moving = 0;                                // index of the movable plane

  std::vector<char> near;       // 0: the sphere touched no wall at the last evaluation, and has not just arrived here
  std::vector<char> touched;    // 0: the sphere has touched no wall; 1: it may have
  std::vector<int> spheres;     // spheres that can reach a wall before the next reneighboring, in order
  bool listed = false;          // true if this list is current
  bool grows = false;           // true if radii may change during a run
  double listed_level = 0.0;    // position of the movable plane when the list was made
  granwave::WallHistory histories;
  std::vector<granwave::Front> fronts;    // arrival of the largest force of each sphere

  /* Histories and output of the spheres at the start of a minimization, from which every evaluation in it continues: a
     position that it tries and does not keep leaves no dent. */
  struct Start {
    bool kept = false;
    granwave::WallHistory histories;
    std::vector<double> reports;
    std::vector<granwave::Front> fronts;
  };
  Start start;

  double wall_force[3];              // force of the spheres of this processor on the walls
  granwave::ExactSum on_plane[2];    // force and stiffness of the contacts of this processor with a movable plane
  double contact_stiffness = 0.0;    // sum over all processors
  bigint tallied = -1;
  enum {
    STORED,
    DISSIPATED_SUM,
    YIELDED,
    BEYOND_LAW,
    TANGENTIAL_STORED,
    FRICTION_LOSS_SUM,
    VISCOUS_SUM,
    ROLLING,
    ROLLED,
    TWISTING,
    TWISTED,
    ADHESIVE,
    N_TOTALS
  };
  double totals[N_TOTALS];    // of all processors
  int extensive[21] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
};

}    // namespace LAMMPS_NS

#endif

#endif
