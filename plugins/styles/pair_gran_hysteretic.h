// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: contact of spheres with laws that depend on their history, and with friction.

   pair_style gran/hysteretic gap
   pair_coeff I J law ...            (law_arguments.h)

   A contact's dent stays when the spheres part, until the gap between them exceeds `gap`. The pairs near enough to
   touch are kept as flat arrays beside LAMMPS's list, from one reneighbouring to the next; in between
   (FixGranHystereticHistory) the dents travel with the spheres.

   A particle of radius 0 is the flat face of a larger body, such as the end node of an elastic bar: it touches a sphere
   where the distance is the sphere's radius, with R* that of the sphere, without friction. Two faces never batch. */

#ifndef LMP_PAIR_GRAN_HYSTERETIC_H
#define LMP_PAIR_GRAN_HYSTERETIC_H

#include "../laws/contact_batch.h"
#include "../laws/contact_history.h"
#include "../laws/contact_law.h"
#include "../laws/law_arguments.h"
#include "pair.h"
#include "../laws/twofold_sum.h"

#include <functional>
#include <vector>

namespace LAMMPS_NS {

class FixGranHystereticHistory;

class PairGranHysteretic : public Pair {
 public:
  static constexpr const char *STYLE = "gran/hysteretic";

  /* State of one contact for output, in physical units. */
  struct Report {
    int i, j;    // local index; j may be a ghost, -1 for a forgotten dent
    tagint tag_i, tag_j;
    double overlap, force;    // now; overlap < 0 is a gap
    double peak_force, elastic, dissipated, share_i;
    double tangential_force, tangential_elastic, frictional_loss;
    double effective_radius;
    double initial;    // the dent before this run
    bool live, yielded;
    granwave::Dent dent;
  };

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
  double memory_usage() override;

  /* Bring the records of the spheres up to date; release also invalidates the flat list. */
  void publish_contacts();
  void release_contacts();

  /* Call back for every contact of this processor: a pair of which one sphere is a ghost is reported by both owners,
     a forgotten dent by the owner of each sphere. Needs a current list (after setup or during a run). */
  void for_each_dent(const std::function<void(const Report &)> &);

  enum { DISSIPATED, YIELDED, BEYOND_LAW, BEYOND_HALF, LARGEST_FORCE, TANGENTIAL, FRICTIONAL, N_TOTALS };    // in pvector

  /* Sum up this processor's part of the totals, of which LARGEST_FORCE is the first one's alone; returns the energy that
     the normal forces store. A collective call. Needs a current list. */
  double tally_totals();

  /* Call back for the one pair of these ids, where this processor has it in reach. */
  void visit_pair(tagint, tagint, const std::function<void(const Report &)> &);

  /* Dents from before the run (gran_dents.h). `prepare` comes first, with LAMMPS's own lists built anew: from then on
     contacts tell their initial dents from later ones. `begin` makes all dents so far initial ones. `set_dents` asks for the
     dent of each near pair, lower id first (negative: none given) and reports its status. All three on all processors. */
  enum class DentStatus { SET, TOO_DEEP, OUT_OF_REACH };
  void prepare_initial_dents();
  void begin_initial_dents();
  void set_dents(const std::function<double(tagint, tagint)> &dent,
                 const std::function<void(tagint, tagint, DentStatus)> &report);

 private:
  // Spheres of a lattice that just touch overlap or part by the rounding of their positions. Overlaps below this part of
  // the distance are that noise: the force that they would give is below 1e-12 F_y.
  static constexpr double ROUNDING = 5e-13;

  // Spheres out of reach of others are looked at so rarely that it costs nothing; a NaN beside others is found in its step.
  static constexpr int STEPS_BETWEEN_CHECKS = 100;
  int evaluations = 0;

  static constexpr int FLAGS_AT_A_TIME = 8;    // of has_spring, read together

  enum { OVERLAP, PEAK_OVERLAP, PEAK_FORCE, LOST, TIME_FIRST, TIME_PEAK, TIME_YIELD, N_SINGLE };    // of compute pair/local

  /* Pairs of spheres within reach, row by row as in LAMMPS's half list. */
  struct Contacts {
    bool valid = false, published = false;
    int owned = 0;                  // spheres of this processor when the list was built
    bool ordered = true;            // rows rise, and no partner comes before its row
    int span = 0;                   // largest distance in index between a row and an owned partner
    std::vector<int> row, begin;    // sphere of each row; where its pairs begin (one longer)
    std::vector<int> partner;       // local or ghost index
    std::vector<double> peak;       // largest overlap ever
    std::vector<double> time_first, time_peak, time_yield;
    int n_extra = 0;              // doubles of history that the laws in use have beyond the peak
    std::vector<double> extra;    // so many for each pair
    std::vector<int> turning;     // index into turnings, or -1 while Hertzian
    std::vector<granwave::Turning> turnings;
    std::vector<double> work_lost;                     // normalised dissipated energy at the turning; -1: not yet asked for
    std::vector<double> circle;                        // with friction: normalised area at the turning
    std::vector<granwave::TangentialSpring> spring;    // with friction: force on the row's sphere
    std::vector<char> has_spring;                      // with friction: 1 if there is a spring now; FLAGS_AT_A_TIME longer
    std::vector<double> initial, reached;    // with initial dents: dent before this run, largest overlap of this run
    std::vector<double> initial_extra;       // likewise: the law's doubles before this run
    std::vector<tagint> row_tag, partner_tag;
    std::vector<double> row_radius, partner_radius;    // the first entry serves all when all spheres are equal
    std::vector<int> row_type, partner_type;
  };

  struct PairParameters {    // of a contact, from its two spheres
    double radius_i, radius_j, radsum, touch_sq, largest_overlap;
    granwave::ScaledLaw contact;
    double friction;           // 0 where either is a face
    double shear_stiffness;    // 8 G*
    granwave::TangentialModel tangential_model = granwave::TangentialModel::MINDLIN_RESCALE;
  };

  struct Batch : granwave::ContactBatch {
    const PairParameters *pair[CAPACITY];
    void set(int m, const PairParameters &);
  };

  /* R* of two spheres, or of a sphere and a flat face (radius 0). */
  static double effective_radius(double ri, double rj) { return ri > 0.0 && rj > 0.0 ? ri * rj / (ri + rj) : ri + rj; }

  /* Overlaps beyond this are an error: a sphere's centre is near the other surface, or the face near the sphere's centre. */
  static double largest_overlap(double ri, double rj)
  {
    return ri > 0.0 && rj > 0.0 ? (ri < rj ? ri : rj) : 0.5 * (ri + rj);
  }

  void allocate();
  granwave::ContactLaw &law(int itype, int jtype) { return laws[itype * (atom_types + 1) + jtype]; }
  static double touch_squared(double radsum) { return radsum * radsum * (1.0 - 2.0 * ROUNDING); }
  PairParameters pair_parameters(int itype, int jtype, double ri, double rj);
  void build_contacts();
  void check_displacements();
  void restore_history();
  void require_contacts();
  enum class Tally { NONE, VIRIAL, EACH_PAIR };
  template <bool UNIFORM> void compute_forces(Tally);
  void compute_batch(Batch &, Tally);
  void update_history(Batch &);
  void compute_tangential(Batch &);
  void accumulate(const Batch &, granwave::TwofoldSums &, const double (&on_i)[3][Batch::CAPACITY],
                  const double (&on_j)[3][Batch::CAPACITY]);
  void tally(const Batch &, Tally);
  double plastic_force(int k, double overlap, const granwave::ScaledLaw &, bool raised);
  void release_spring(int k);
  bool any_spring(int begin, int end) const;
  void raise_reached(int k, double overlap);
  double circle_squared(int k, double overlap, const granwave::ScaledLaw &);
  int cached_turning(int k, const granwave::ScaledLaw &);
  granwave::LawHistory law_history(int k) const;
  granwave::Dent dent_of(int k) const;
  granwave::BlockView block_view(int k) const;
  void pack_block(int k, double side, double *block) const;
  void unpack_block(int k, const granwave::BlockLayout &, const double *block);
  void reset_history(int k, double peak, bool initial);
  void forget(int row, int k);
  double largest_force_of_run(const granwave::ScaledLaw &, const granwave::LawHistory &, const granwave::BlockView &,
                              double overlap) const;
  void fill_report(Report &, const granwave::ScaledLaw &, const granwave::BlockView &, double overlap) const;
  Report report_pair(int i, int j, int k, double rsq);
  [[noreturn]] void overlap_error(int i, int j, double overlap);

  double gap = 0.0;
  int atom_types = 0;
  int restart_format = 1;    // of the file that is written or read
  std::vector<granwave::ContactLaw> laws;
  std::vector<granwave::LawArguments> coefficients;    // as set by pair_coeff, to mix from and for restarts
  std::vector<double> largest_radius;
  bool uniform = false;
  bool has_friction = false;         // any friction, ever
  bool has_initial_dents = false;    // dents of earlier runs are told from those of this one
  Contacts contacts;
  granwave::TwofoldSums force_sums, torque_sums;
  double now = 0.0;                // simulated time of this force evaluation
  bool springs_advance = false;    // time passes in it
  FixGranHystereticHistory *fix_history = nullptr;
};

}    // namespace LAMMPS_NS

#endif
