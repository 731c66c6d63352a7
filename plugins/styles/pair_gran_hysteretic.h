// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: contact of spheres with history-dependent normal forces and with friction.

   pair_style gran/hysteretic gap [forgotten sum|list]
   pair_coeff I J law ...            (law_arguments.h)

   The dent of a contact is kept after separation, until the gap between the spheres exceeds `gap`; then it is added to the sums of
   its two spheres, or with `list` stays on record. Pairs within reach are stored
   in flat arrays that supplement LAMMPS's neighbor list (contact_list.h). Those of spheres that go to another processor, and what is
   written to a restart file, are stored with the spheres (FixGranHystereticHistory).

   A particle of radius 0 is the flat face of a larger body, such as the end node of an elastic bar: it touches a sphere if
   their distance is the radius of the sphere, with R* the radius of the sphere, without friction. Two faces never touch.

   Types of fix gran/cylinder are cylinders. Their pairs, those with cohesion, and those whose force is a power of the overlap, are in further rows
   of the flat list, evaluated one by one (pair_gran_hysteretic_shapes.cpp). So are pairs across a periodic boundary, which are in the
   list twice, once for each sphere: both are computed from the same numbers, so that they have one history
   (pair_gran_hysteretic_images.cpp). */

#ifdef PAIR_CLASS
// clang-format off
PairStyle(gran/hysteretic,PairGranHysteretic);
// clang-format on
#else

#ifndef LMP_PAIR_GRAN_HYSTERETIC_H
#define LMP_PAIR_GRAN_HYSTERETIC_H

#include "../kernels/contact_step.h"
#include "../kernels/line_batch.h"
#include "../kernels/plastic_batch.h"
#include "contact_list.h"
#include "contact_report.h"
#include "ghost_velocities.h"
#include "moved_mass.h"
#include "pair.h"
#include "pair_batch.h"
#include "pair_geometry.h"

#include "atom.h"

#include <map>

namespace LAMMPS_NS {

class PairGranHysteretic : public Pair {
 public:
  static constexpr const char *STYLE = "gran/hysteretic";

  using Report = granwave::ContactReport;

  /* Return the pair style in use, also as a sub-style of pair_style hybrid, or as gran/hysteretic/kk; null if there is none. */
  static PairGranHysteretic *find(Force *);

  explicit PairGranHysteretic(LAMMPS *);
  ~PairGranHysteretic() override;

  void settings(int, char **) override;
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override;
  void compute(int, int) override;
  double single(int, int, int, int, double, double, double, double &) override;
  void write_restart(FILE *) override;
  void read_restart(FILE *) override;
  void write_restart_settings(FILE *) override;
  void read_restart_settings(FILE *) override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  double memory_usage() override;

  /* Call a function for every contact of this processor: a pair with a ghost sphere is reported by both owners, a forgotten
     dent on record by the owner of each sphere. Requires a current list (after setup or during a run). */
  void for_each_dent(const std::function<void(const Report &)> &);

  /* Sums over forgotten dents of an owned sphere without a record. */
  granwave::ForgottenContacts forgotten(int i) const { return fix_history->history.forgotten(i); }

  // in pvector
  enum {
    DISSIPATED,
    YIELDED,
    BEYOND_LAW,
    BEYOND_HALF,
    LARGEST_FORCE,
    TANGENTIAL,
    FRICTIONAL,
    VISCOUS,
    ROLLING,
    ROLLED,
    TWISTING,
    TWISTED,
    ADHESIVE,
    N_TOTALS
  };

  /* Sum the part of this processor in the totals; LARGEST_FORCE is nonzero only on the first processor. Returns the energy stored
     by the normal forces. A collective call. Requires a current list. */
  double tally_totals();

  /* Call a function for the pair with these IDs, if it is in the list of this processor. */
  void visit_pair(tagint, tagint, const std::function<void(const Report &)> &);

  /* Initial dents (gran_dents.h). `prepare` must be called first, with LAMMPS's neighbor lists rebuilt: from then on initial
     dents are stored. `begin` turns all dents so far into initial dents, or forgets them. `set_contacts` sets those of pairs of IDs, lower
     first, and returns how this went for the pairs within reach. All of them are called on all processors. */
  using Ids = std::pair<tagint, tagint>;
  enum DentStatus { SET = 4, TOO_DEEP = 8, OUT_OF_REACH = 16, OTHER_LAW = 32 };
  void prepare_initial_dents();
  void begin_initial_dents(bool keeps);
  std::map<Ids, DentStatus> set_contacts(const std::map<Ids, granwave::KnownContact> &);

 protected:    // for its version on cards
  // Isolated spheres are checked so rarely that the cost is negligible; near other spheres a NaN is found at once.
  static constexpr int STEPS_BETWEEN_CHECKS = 100;
  // 13: the blocks of records have only what is in use (fix_gran_hysteretic_history.cpp)
  static constexpr int EARLIEST_RESTART_FORMAT = 12, RESTART_FORMAT = 13;

  /* Columns of compute pair/local. The first ten are those of LAMMPS's pair styles gran/..., which compute fabric reads. */
  enum {
    TANGENTIAL_FORCE,
    TANGENTIAL_MAGNITUDE = TANGENTIAL_FORCE + 3,
    NORMAL_VELOCITY,
    TANGENTIAL_VELOCITY = NORMAL_VELOCITY + 3,
    OVERLAP = TANGENTIAL_VELOCITY + 3,
    PEAK_OVERLAP,
    PEAK_FORCE,
    LOST,
    TIME_FIRST,
    TIME_PEAK,
    TIME_YIELD,
    N_SINGLE
  };

  using PairParameters = granwave::PairParameters;
  using Batch = granwave::PairBatch;

  enum class Message { MASSES, VELOCITIES };    // to ghosts
  enum class Tally { NONE, VIRIAL, EACH_PAIR };

  // settings and laws
  void allocate();
  void refuse_line_searches();
  int find_memory();
  void create_history(int n_extra);
  void require_bodies();
  void find_largest_radii();
  int find_initial_places();
  double init_shape(int itype, int jtype);
  void set_parameters();
  PairParameters pair_parameters(int i, int j)
  {
    return laws.parameters(atom->type[i], atom->type[j], atom->radius[i], atom->radius[j]);
  }
  // law of a forgotten contact of sphere i
  granwave::ScaledLaw law_of(int i, const granwave::ContactRecord &record)
  {
    return laws.scaled(atom->type[i], record.partner_type, atom->radius[i], record.partner_radius);
  }

  // list of contacts
  void build_contacts();
  void require_contacts();
  void require_room();
  void require_largest_radii();
  void require_same_ids();
  void check_displacements();
  void publish_contacts();
  void release_contacts();
  void release_contact(int k);
  void end_contact(int i, const granwave::ContactRecord &, const double *block);
  void forget(int row, int k);
  void forget_far_pairs(int r);
  void sum_up(int i, const granwave::ContactRecord &, const double *block);

  // ghosts
  void renew_ghosts();
  void send(Message);
  void set_relative_velocities(Batch &) const;

  // a force evaluation, and its batches
  void begin_evaluation();
  void compute_forces(Tally);
  void compute_special(Tally);
  void compute_special_batch(Tally);
  bool add_spheres(int k, int i, int j);
  bool add_special(int r, int k);
  void compute_batch(Tally, bool special = false);
  void set_elastic(Batch &);
  void update_history(Batch &);
  void compute_plastic(Batch &, std::uint64_t beyond, std::uint64_t raised);
  void compute_cohesion(Batch &);
  void compute_viscous(Batch &);
  void compute_tangential(Batch &, bool special);
  bool advance_friction(Batch &);
  bool add_damping(Batch &);
  void compute_resistance(const Batch &, const double *circle, double (*moment)[3]);
  void tally(const Batch &, Tally);
  double approach(const Batch &, int m) const;
  double effective_mass(const Batch &, int m) const;
  double tangent_stiffness(const Batch &, int m);
  [[noreturn]] void overlap_error(int i, int j, double overlap);

  // output
  struct TotalledContact;
  void add_to_totals(const TotalledContact &);
  double total_pairs();
  void total_records();
  void total_forgotten();
  Report report_forgotten(int i, const granwave::ContactRecord &, const double *block);
  Report report_pair(int i, int j, int k, double side, double rsq);
  Report report_pair(std::size_t r, int k);
  void write_lammps_columns(const Report &);

  double gap = 0.0;
  bool lists_forgotten = false;    // true if forgotten dents stay on record
  bool normals_initial = false;    // true if normals are those of the initial places
  bool from_restart = false;       // true if the settings are from a restart file

  granwave::PairLaws laws{lmp};
  granwave::PairGeometry geometry{lmp, laws};
  std::vector<double> largest_radius;    // by type
  bool radii_vary = false;               // true if a fix may change radii during a run
  bool uniform = false;                  // true if all spheres are equal
  bool only_spheres = false;             // true if all pairs touch by the distance of their centers, without cohesion
  bool has_rate = false;                 // true if a law depends on the rate
  bool has_dashpot = false;              // true if a pair of types has one

  granwave::ContactMemory has;    // parts exist from the first pair_coeff or initial dent that requires them
  granwave::ContactList contacts{has};
  FixGranHystereticHistory *fix_history = nullptr;
  bool lost_contacts = false;    // true if it was deleted elsewhere

  granwave::MovedMass masses;    // with a dashpot
  granwave::GhostVelocities ghosts;
  bool sends_velocities = false;    // true if laws need velocities of ghosts that LAMMPS does not send
  Message message = Message::MASSES;

  bigint evaluations = 0;
  double now = 0.0;         // simulation time of this force evaluation
  granwave::Step step{};    // that histories are advanced by in this force evaluation
  granwave::TouchingPairs pairs{};
  Batch batch;                         // of the pairs found last
  granwave::LoadingBatch loading{};    // those beyond their elastic limit
  granwave::UnloadingBatch unloading{};
  granwave::LineBatch lines{};    // those along lines
};

}    // namespace LAMMPS_NS

#endif

#endif
