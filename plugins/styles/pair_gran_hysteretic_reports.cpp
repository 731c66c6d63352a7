// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: output of its contacts: totals, one pair, all pairs. */

#include "pair_gran_hysteretic.h"

#include "comm.h"
#include "error.h"
#include "motion.h"

using namespace LAMMPS_NS;
using namespace granwave;

/* Contact that is added to the totals. */
struct PairGranHysteretic::TotalledContact {
  const ScaledLaw &law;
  LawHistory history;
  BlockView view;
  double dissipated, peak_force;    // by its law
  double overlap;
  double weight;    // one half if its other sphere adds it, too
};

void PairGranHysteretic::add_to_totals(const TotalledContact &contact)
{
  const ScaledLaw &law = contact.law;
  const LawHistory &h = contact.history;
  const BlockView &view = contact.view;
  const double weight = contact.weight;
  pvector[TANGENTIAL] += weight * has.tangential_energy(view.spring, view.extra);
  pvector[FRICTIONAL] += weight * view.spring.loss;
  pvector[VISCOUS] += weight * has.viscous_loss(h.extra);
  if (has.resistance) {
    const ResistanceHistory resisted = has.resistance_of(h.extra);
    pvector[ROLLING] += weight * resisted.rolling.stored();
    pvector[ROLLED] += weight * resisted.rolling.loss;
    pvector[TWISTING] += weight * resisted.twisting.stored();
    pvector[TWISTED] += weight * resisted.twisting.loss;
  }
  if (law.cohesive()) pvector[ADHESIVE] += weight * has.cohesion_of(h.extra).lost;
  const double largest = largest_force_of_run(has, law, h, view, contact.overlap, contact.peak_force);
  pvector[LARGEST_FORCE] = std::max(pvector[LARGEST_FORCE], largest);
  const int beyond = beyond_range(law, h.peak);
  if (beyond > 0) pvector[BEYOND_HALF] += weight;
  if (beyond > 1) pvector[BEYOND_LAW] += weight;
  if (!law.yielded(h.peak) || h.peak <= view.initial) return;
  pvector[YIELDED] += weight;
  pvector[DISSIPATED] += weight * (contact.dissipated - law.dissipated_energy({view.initial, view.initial_extra}));
}

/* Add the pairs of the list; a pair shared with another processor counts half. Returns the energy stored by their normal
   forces. */
double PairGranHysteretic::total_pairs()
{
  const int nlocal = atom->nlocal;
  ContactList &c = contacts;
  double stored = 0.0;
  PairParameters p{};
  if (uniform && nlocal > 0) p = pair_parameters(0, 0);
  c.each_dent([&](int, int k, int i, int j) {
    if (!uniform) p = pair_parameters(i, j);
    const LawHistory h = c.law_history(k);
    TotalledContact contact{p.contact, h, c.view(k), 0.0, 0.0, p.radsum - geometry.distance(i, j), 1.0};
    if (i >= nlocal || j >= nlocal) contact.weight = 0.5;
    const Turning *turning = nullptr;
    if (p.contact.yielded(h.peak)) {
      const int t = c.cached_turning(k, p.contact);
      turning = &c.turnings[t];
      if (c.work_lost[t] == -1.0) c.work_lost[t] = p.contact.dissipated_energy(*turning, h.extra);
      contact.dissipated = c.work_lost[t];
      contact.peak_force = p.contact.peak_force(*turning);
    } else {
      contact.peak_force = p.contact.elastic_force(h.peak);
    }
    stored += contact.weight * has.stored_energy(p.contact, contact.overlap, h, turning);
    add_to_totals(contact);
  });
  return stored;
}

/* Add the forgotten contacts on record, one half for each of the two spheres. */
void PairGranHysteretic::total_records()
{
  ContactHistory &history = fix_history->history;
  history.each_record(atom->nlocal, [&](int i, int m, const ContactRecord &record) {
    if (record.live) return;
    const ScaledLaw law = law_of(i, record);
    const BlockView view(history.layout(), history.block(i, m));
    const LawHistory h{record.dent.peak, view.extra};
    add_to_totals({law, h, view, law.dissipated_energy(h), law.peak_force(h), 0.0, 0.5});
  });
}

/* Add the sums of forgotten contacts without a record. */
void PairGranHysteretic::total_forgotten()
{
  const ContactHistory &history = fix_history->history;
  if (!history.has_forgotten()) return;
  for (int i = 0; i < atom->nlocal; i++) {
    const ForgottenContacts sums = history.forgotten(i);
    pvector[DISSIPATED] += 0.5 * sums.dissipated;
    pvector[FRICTIONAL] += 0.5 * (sums.frictional_loss - sums.rolling_loss - sums.twisting_loss);
    pvector[ROLLED] += 0.5 * sums.rolling_loss;
    pvector[TWISTED] += 0.5 * sums.twisting_loss;
    pvector[VISCOUS] += 0.5 * sums.viscous_loss;
    pvector[ADHESIVE] += 0.5 * sums.adhesive_loss;
    pvector[YIELDED] += 0.5 * sums.yielded;
    pvector[BEYOND_HALF] += 0.5 * sums.beyond_half;
    pvector[BEYOND_LAW] += 0.5 * sums.beyond_law;
    pvector[LARGEST_FORCE] = std::max(pvector[LARGEST_FORCE], sums.peak_force);
  }
}

double PairGranHysteretic::tally_totals()
{
  require_contacts();
  require_finite_motion(lmp);
  std::fill_n(pvector, static_cast<int>(N_TOTALS), 0.0);
  const double stored = total_pairs();
  total_records();
  total_forgotten();

  double largest_force = 0.0;
  MPI_Allreduce(&pvector[LARGEST_FORCE], &largest_force, 1, MPI_DOUBLE, MPI_MAX, world);
  pvector[LARGEST_FORCE] = comm->me == 0 ? largest_force : 0.0;    // compute pair sums over processors
  double all_energies = stored;
  for (const int energy : {DISSIPATED, TANGENTIAL, FRICTIONAL, VISCOUS, ROLLED, TWISTED, ADHESIVE})
    all_energies += pvector[energy];
  if (!std::isfinite(all_energies))
    error->one(FLERR, "Pair style gran/hysteretic: the energy of the contacts is not a number: positions or velocities "
                      "are wrong, or the timestep is far too large");
  return stored;
}

/* Report on spheres i and j, whose pair k (-1: not in the list) is in the row of i (side 1) or of j (-1). */
PairGranHysteretic::Report PairGranHysteretic::report_pair(int i, int j, int k, double side, double rsq)
{
  const PairParameters p = pair_parameters(i, j);
  Report report{};
  report.i = i;
  report.j = j;
  report.tag_i = atom->tag[i];
  report.tag_j = atom->tag[j];
  report.live = true;
  report.overlap = p.radsum - geometry.distance(i, j, rsq);
  std::vector<double> fresh;    // zero history of a pair that is not in the list
  BlockView view;
  if (k >= 0) {
    report.dent = contacts.dent(k);
    view = contacts.view(k);
    view.side = side;
    for (double &force : view.spring.force) force *= side;
  } else {
    fresh.assign(has.n, 0.0);
    view.extra = view.initial_extra = fresh.data();
  }
  const bool near = p.contact.cohesive() || report.overlap > TouchingPairs::ROUNDING * p.radsum;
  fill_report(report, has, p.contact, view, near ? report.overlap : 0.0);
  return report;
}

/* Report on pair k of row r. The first sphere is that of the row unless that is a ghost. */
PairGranHysteretic::Report PairGranHysteretic::report_pair(std::size_t r, int k)
{
  int i = contacts.row[r], j = contacts.partner[k];
  const bool ghost = i >= atom->nlocal;
  if (ghost) std::swap(i, j);
  Report report = report_pair(i, j, k, ghost ? -1.0 : 1.0, geometry.distance_squared(i, j));
  double normal[3];
  geometry.unit_normal(i, j, normal);
  for (int d = 0; d < 3; d++) report.on_first[d] = report.force * normal[d] + report.tangential[d];
  return report;
}

void PairGranHysteretic::for_each_dent(const std::function<void(const Report &)> &visit)
{
  require_contacts();
  require_finite_motion(lmp);
  contacts.each_dent([&](int r, int k, int, int) { visit(report_pair(r, k)); });
  ContactHistory &history = fix_history->history;
  history.each_record(atom->nlocal, [&](int i, int m, const ContactRecord &record) {
    if (!record.live) visit(report_forgotten(i, record, history.block(i, m)));
  });
}

/* Report on a forgotten contact of sphere i. */
PairGranHysteretic::Report PairGranHysteretic::report_forgotten(int i, const ContactRecord &record, const double *block)
{
  Report report{};
  report.i = i;
  report.j = -1;
  report.tag_i = atom->tag[i];
  report.tag_j = static_cast<tagint>(record.partner);
  report.dent = record.dent;
  report.overlap = -gap;
  fill_report(report, has, law_of(i, record), BlockView(fix_history->history.layout(), block), 0.0);
  return report;
}

/* Add a forgotten contact of sphere i to the sums of the sphere. */
void PairGranHysteretic::sum_up(int i, const ContactRecord &record, const double *block)
{
  const Report report = report_forgotten(i, record, block);
  const int beyond = beyond_range(law_of(i, record), record.dent.peak);
  ForgottenContacts &sums = fix_history->history.forgotten_to_change(i);
  sums.dissipated += report.dissipated;
  sums.own_dissipated += report.share_i * report.dissipated;
  sums.frictional_loss += report.frictional_loss;
  sums.viscous_loss += report.viscous_loss;
  sums.adhesive_loss += report.adhesive_loss;
  sums.rolling_loss += report.rolling_loss;
  sums.twisting_loss += report.twisting_loss;
  sums.yielded += report.yielded;
  sums.beyond_half += beyond > 0;
  sums.beyond_law += beyond > 1;
  if (report.peak_force > sums.peak_force) {
    sums.peak_force = report.peak_force;
    sums.time_peak = record.dent.time_peak;
  }
  sums.peak_overlap = std::max(sums.peak_overlap, record.dent.peak);
  earliest(sums.time_first, report.time_first);
  earliest(sums.time_yield, record.dent.time_yield);
}

void PairGranHysteretic::visit_pair(tagint one, tagint other, const std::function<void(const Report &)> &visit)
{
  require_contacts();
  const auto [lower, higher] = std::minmax(one, other);
  if (const auto [r, k] = contacts.find(lower, higher); k >= 0) visit(report_pair(r, k));
}

/* Columns of LAMMPS's pair styles gran/...: force on the first sphere by friction, velocity of its centre relative to that of the
   second, along the normal and across it. All zero where the spheres do not touch. */
void PairGranHysteretic::write_lammps_columns(const Report &report)
{
  std::fill_n(svector, static_cast<int>(OVERLAP), 0.0);
  if (!report.touches) return;
  std::copy_n(report.tangential, 3, svector + TANGENTIAL_FORCE);
  svector[TANGENTIAL_MAGNITUDE] = report.tangential_force;
  double normal[3];
  geometry.unit_normal(report.i, report.j, normal);
  const double *const vi = atom->v[report.i];
  const double *const vj = atom->v[report.j];
  const double velocity[3] = {vi[0] - vj[0], vi[1] - vj[1], vi[2] - vj[2]};
  const double approach = dot(velocity, normal);
  for (int d = 0; d < 3; d++) {
    svector[NORMAL_VELOCITY + d] = approach * normal[d];
    svector[TANGENTIAL_VELOCITY + d] = velocity[d] - approach * normal[d];
  }
}

double PairGranHysteretic::single(int i, int j, int, int, double rsq, double, double, double &fforce)
{
  require_contacts();
  const double square = geometry.distance_squared(i, j);    // with the rounding of the run across a periodic boundary
  if (std::fabs(rsq - square) > 1e-9 * rsq)
    error->one(FLERR, "Pair style gran/hysteretic has forces of present contacts only: pair_write is not supported");
  const auto [lower, higher] = std::minmax(atom->tag[i], atom->tag[j]);
  const auto [r, k] = contacts.find(lower, higher);
  const double side = k >= 0 && atom->tag[contacts.row[r]] != atom->tag[i] ? -1.0 : 1.0;
  const Report report = report_pair(i, j, k, side, square);
  write_lammps_columns(report);
  svector[OVERLAP] = report.overlap;
  svector[PEAK_OVERLAP] = report.dent.peak;
  svector[PEAK_FORCE] = report.peak_force;
  svector[LOST] = report.dissipated;
  svector[TIME_FIRST] = report.time_first;
  svector[TIME_PEAK] = report.dent.time_peak;
  svector[TIME_YIELD] = report.dent.time_yield;
  fforce = report.force / std::sqrt(rsq);
  return report.elastic;
}
