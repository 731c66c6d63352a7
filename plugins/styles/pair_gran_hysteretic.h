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

#include "../laws/law_arguments.h"
#include "../laws/plastic_batch.h"
#include "contact_list.h"
#include "fix_gran_cylinder.h"
#include "fix_gran_hysteretic_history.h"
#include "ghost_velocities.h"
#include "moved_mass.h"
#include "pair.h"

#include "atom.h"

#include <array>
#include <map>

namespace LAMMPS_NS {

class PairGranHysteretic : public Pair {
 public:
  static constexpr const char *STYLE = "gran/hysteretic";

  /* State of one contact for output, in physical units. */
  struct Report {
    int i, j;    // local index; j may be a ghost, -1 for a forgotten dent on record
    tagint tag_i, tag_j;
    double overlap, force;    // present values; overlap < 0 is a gap
    double on_first[3];       // present force on i: normal and tangential; of for_each_dent, for live contacts
    double peak_force, elastic, dissipated, share_i;
    double time_first;    // arrival of the force
    double tangential_force, tangential_elastic, frictional_loss;
    double rolling_loss, twisting_loss;    // part of the frictional loss
    double viscous_loss, adhesive_loss;
    double tangential[3];    // tangential force on sphere i
    double effective_radius;
    double initial;    // initial dent
    bool live, yielded;
    bool touches;    // or is held by a neck
    granwave::Dent dent;
  };

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

  /* Sums over the forgotten dents of an owned sphere that are not on record. */
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
  // Spheres with no other within reach are checked so rarely that the cost is negligible; near others a NaN is found at once.
  static constexpr int STEPS_BETWEEN_CHECKS = 100;
  bigint evaluations = 0;
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

  struct PairParameters {    // parameters of a contact, from its two spheres
    double radius_i, radius_j, radsum, touch_sq, largest_overlap;
    double root_radius;    // square root of R*
    granwave::ScaledLaw contact;
    double friction;           // 0 if one of the two is a face
    double shear_stiffness;    // 8 G*
    granwave::TangentialModel tangential_model = granwave::TangentialModel::MINDLIN_RESCALE;
    granwave::ViscousLoss loss;
    const granwave::ResistanceModel *resistance = nullptr;    // to rolling and twisting, null if there is none
  };

  struct SpecialPair {                                 // pair of a cylinder, or with a power of the overlap
    std::unique_ptr<granwave::ElasticContact> line;    // of parallel cylinders
    granwave::ScaledLaw contact;
  };

  struct Batch : granwave::ContactBatch {
    const PairParameters *pair[CAPACITY];
    PairParameters parameters[CAPACITY];    // of each pair, or only the first if all are equal; unused if known by type
    double pressing[CAPACITY];              // of pairs with cohesion: normal force that limits friction
    double damping[CAPACITY];               // with damping along the surface: its coefficient; below 0: a run is continued
    void set(int m, const PairParameters &p)
    {
      pair[m] = &p;
      radius_i[m] = p.radius_i;
      radius_j[m] = p.radius_j;
      radsum[m] = p.radsum;
      root_radius[m] = p.root_radius;
      hertz[m] = p.contact.hertz();
      shear_stiffness[m] = p.shear_stiffness;
      largest_overlap[m] = p.largest_overlap;
      elastic_limit[m] = p.contact.elastic_limit();
      friction[m] = p.friction;
      keeps[m] = p.tangential_model == granwave::TangentialModel::MINDLIN ? 1.0 : 0.0;
    }
  };

  /* Effective radius of two spheres, or of a sphere and a flat face (radius 0). */
  static double effective_radius(double ri, double rj) { return ri > 0.0 && rj > 0.0 ? ri * rj / (ri + rj) : ri + rj; }

  /* Largest overlap that is not an error: beyond it the center of a sphere is near the other surface or face. */
  static double largest_overlap(double ri, double rj)
  {
    return ri > 0.0 && rj > 0.0 ? (ri < rj ? ri : rj) : 0.5 * (ri + rj);
  }

  void publish_contacts();
  void refuse_line_searches();
  void require_room();
  void require_largest_radii();
  void release_contacts();
  void allocate();
  granwave::ContactLaw &law(int itype, int jtype) { return laws[itype * (atom_types + 1) + jtype]; }
  PairParameters pair_parameters(int itype, int jtype, double ri, double rj);
  PairParameters pair_parameters(int i, int j)
  {
    return pair_parameters(atom->type[i], atom->type[j], atom->radius[i], atom->radius[j]);
  }
  void find_initial_places();
  double init_shape(int itype, int jtype);
  bool is_special(int itype, int jtype) const { return has_special && special_types[itype * (atom_types + 1) + jtype]; }
  granwave::ScaledLaw special_law(int itype, int jtype, double ri, double rj);
  granwave::ScaledLaw scaled_law(int itype, int jtype, double ri, double rj)
  {
    if (is_special(itype, jtype)) return special_law(itype, jtype, ri, rj);
    return {law(itype, jtype), effective_radius(ri, rj), ri, rj};
  }
  granwave::ScaledLaw law_of(int i, const granwave::ContactRecord &record)    // of a forgotten contact of sphere i
  {
    return scaled_law(atom->type[i], record.partner_type, atom->radius[i], record.partner_radius);
  }
  using Vector = std::array<double, 3>;
  const FixGranHystereticHistory::Images &images(int i) const { return fix_history->images(i); }
  bool crosses(int i, int j) const { return !images(i).none() || !images(j).none(); }
  Vector vector_between(int i, int j) const;
  Vector relative_velocity(int i, int j) const;
  void renew_ghosts();
  enum class Message { MASSES, VELOCITIES };    // to ghosts
  void send(Message);
  void set_relative_velocities(Batch &) const;
  granwave::CylinderPair::Separation separation(int i, int j) const;
  double distance_squared(int i, int j) const;
  double distance(int i, int j, double rsq) const;
  double distance(int i, int j) const { return distance(i, j, distance_squared(i, j)); }
  void build_contacts();
  void begin_evaluation();
  void check_displacements();
  void require_same_ids();
  void end_contact(int i, const granwave::ContactRecord &, const double *block);
  void require_contacts();
  enum class Tally { NONE, VIRIAL, EACH_PAIR };
  void compute_forces(Tally);
  void forget_far_pairs(int r);
  void set_parameters();
  void compute_batch(Tally, bool special = false);
  void compute_special(Tally);
  bool add_special(int r, int k);
  void set_elastic(Batch &);
  void update_history(Batch &);
  double approach(const Batch &, int m) const;
  double effective_mass(const Batch &, int m) const;
  void compute_cohesion(Batch &);
  void compute_viscous(Batch &);
  void compute_tangential(Batch &);
  granwave::SlipContact slip_contact(const Batch &, int m) const;
  void advance_friction(Batch &);
  void add_damping(Batch &);
  void compute_resistance(const Batch &, const double *circle, double (*moment)[3]);
  void tally(const Batch &, Tally);
  void compute_plastic(Batch &, std::uint64_t beyond, std::uint64_t raised);
  void release_contact(int k);
  void forget(int row, int k);
  void sum_up(int i, const granwave::ContactRecord &, const double *block);
  double arrival(const granwave::ScaledLaw &, const granwave::Dent &, const granwave::BlockView &) const;
  double largest_force_of_run(const granwave::ScaledLaw &, const granwave::LawHistory &, const granwave::BlockView &,
                              double overlap, double at_peak) const;
  void fill_report(Report &, const granwave::ScaledLaw &, const granwave::BlockView &, double overlap) const;
  Report report_forgotten(int i, const granwave::ContactRecord &, const double *block);
  Report report_pair(int i, int j, int k, double side, double rsq);
  Report report_pair(std::size_t r, int k);
  void unit_normal(int i, int j, double (&normal)[3]) const;
  void write_lammps_columns(const Report &);
  [[noreturn]] void overlap_error(int i, int j, double overlap);

  double gap = 0.0;
  bool lists_forgotten = false;    // true if forgotten dents stay on record
  bool normals_initial = false;    // true if normals are those of the initial places
  int initial_places = -1;         // index of the custom array that holds these
  int atom_types = 0;
  bool from_restart = false;    // true if the settings are from a restart file
  std::vector<granwave::ContactLaw> laws;
  std::vector<granwave::LawArguments> coefficients;    // as set by pair_coeff, for mixing and restarts
  std::vector<double> largest_radius;
  std::shared_ptr<const granwave::Cylinders> cylinders;    // null if there are none
  bool has_special = false;
  std::vector<char> special_types;                                    // by pair of types
  std::vector<std::unique_ptr<granwave::CylinderPair>> geometries;    // by pair of types, null for spheres
  std::map<std::tuple<int, int, double, double>, SpecialPair> special_pairs;
  bool uniform = false;
  granwave::ContactMemory has;    // each part is there from the first pair_coeff with it on, and from the first initial dent
  bool has_rate = false;          // true if a law depends on the rate
  bool has_dashpot = false;       // true if a pair of types has one
  granwave::MovedMass masses;     // with a dashpot
  bool sends_velocities = false;    // true if laws need velocities of ghosts that LAMMPS does not send
  granwave::GhostVelocities ghosts;
  Message message = Message::MASSES;
  bool flows = false;    // true if velocities jump across periodic boundaries, as those of the box do
  granwave::ContactList contacts{has};
  Batch batch;                         // of the pairs found last
  granwave::LoadingBatch loading{};    // those beyond their elastic limit
  granwave::UnloadingBatch unloading{};
  granwave::LineBatch lines{};    // those along lines
  granwave::TouchingPairs pairs{};
  std::vector<PairParameters> parameters_by_type;    // empty if they are not determined by the types
  double now = 0.0;                                  // simulation time of this force evaluation
  granwave::Step step{};                             // that histories are advanced by in this force evaluation
  FixGranHystereticHistory *fix_history = nullptr;
  bool radii_vary = false;       // true if a fix may change radii during a run
  bool lost_contacts = false;    // true if somebody else deleted it
};

}    // namespace LAMMPS_NS

#endif

#endif
