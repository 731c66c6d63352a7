/* Pair style gran/hysteretic: what it tells of its contacts: totals, one pair, each of them. */

#include "pair_gran_hysteretic.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "finite_motion.h"
#include "fix_gran_hysteretic_history.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using granwave::ContactLaw;
using granwave::ContactPast;
using granwave::ContactScale;
using granwave::Dent;
using granwave::DentRecord;
using granwave::Turning;

/* What the dent from before the run had cost. */

double PairGranHysteretic::lost_before(double initial, const ContactScale &scale, const ContactLaw &contact_law) const
{
  if (initial <= scale.elastic_limit) return 0.0;
  return scale.force * scale.overlap * contact_law.dissipated_energy(contact_law.turning(initial / scale.overlap));
}

/* The largest force of this run: at the peak, or below the dent that was there before. */

double PairGranHysteretic::force_reached(const ContactPast &past, const Dent &dent, double overlap, const ContactScale &scale,
                                         const ContactLaw &contact_law) const
{
  const double reached = std::max(past.reached, overlap);
  if (dent.peak <= scale.elastic_limit) return reached > 0.0 ? scale.hertz * reached * std::sqrt(reached) : 0.0;
  const double a = reached / scale.overlap, peak = dent.peak / scale.overlap;
  return scale.force * (a >= peak ? contact_law.loading(a) : ContactLaw::unloading(a, contact_law.turning(peak)));
}

/* A pair shared with another processor counts half. */

double PairGranHysteretic::tally_totals()
{
  require_contacts();
  granwave::require_finite_motion(lmp);
  double elastic = 0.0, largest_force = 0.0;
  std::fill_n(pvector, static_cast<int>(N_TOTALS), 0.0);
  const double *const *x = atom->x;
  const double *radius = atom->radius;
  const int *type = atom->type;
  const int nlocal = atom->nlocal;
  Contacts &c = contacts;

  const auto count = [&](const ContactLaw &contact_law, const ContactScale &scale, double peak, double peak_force,
                         double dissipated, double between, double weight, const ContactPast &past, double overlap) {
    pvector[TANGENTIAL] += weight * tangential_energy(past.spring);
    pvector[FRICTIONAL] += weight * past.spring.loss;
    if (pasts) peak_force = force_reached(past, {peak}, overlap, scale, contact_law);
    if (peak > scale.elastic_limit) {
      if (peak > past.initial) pvector[YIELDED] += weight;
      pvector[DISSIPATED] += weight * (peak > past.initial ? dissipated - lost_before(past.initial, scale, contact_law) : 0.0);
      if (contact_law.fitted() && peak > 0.1 * between) {
        pvector[BEYOND_HALF] += weight;
        if (peak > 0.2 * between) pvector[BEYOND_LAW] += weight;
      }
      largest_force = std::max(largest_force, peak_force);
    } else {
      largest_force = std::max(largest_force, pasts ? peak_force : scale.hertz * peak * std::sqrt(peak));
    }
  };

  Pairing p{};
  if (uniform && nlocal > 0) p = pairing(type[0], type[0], radius[0], radius[0]);
  for (std::size_t r = 0; r < c.row.size(); r++) {
    const int i = c.row[r];
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      const double peak = c.peak[k];
      if (peak == 0.0) continue;
      const int j = c.partner[k];
      const double weight = j < nlocal ? 1.0 : 0.5;
      if (!uniform) p = pairing(type[i], type[j], radius[i], radius[j]);
      const ContactLaw &contact_law = *p.law;
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
      const double overlap = p.sum_radii - std::sqrt(dx * dx + dy * dy + dz * dz);
      double dissipated = 0.0, peak_force = 0.0;
      if (peak > p.scale.elastic_limit) {
        const int t = turning_of(k, peak / p.scale.overlap, contact_law);
        const double unit = p.scale.force * p.scale.overlap;
        if (c.work_lost[t] == -1.0) c.work_lost[t] = contact_law.dissipated_energy(c.turnings[t]);
        dissipated = unit * c.work_lost[t];
        peak_force = p.scale.force * c.turnings[t].force;
        if (overlap > 0.0) elastic += weight * unit * ContactLaw::elastic_energy(overlap / p.scale.overlap, c.turnings[t]);
      } else if (overlap > 0.0) {
        elastic += weight * 0.4 * p.scale.hertz * overlap * overlap * std::sqrt(overlap);
      }
      count(contact_law, p.scale, peak, peak_force, dissipated, p.effective_radius, weight, past_of(k, 1.0), overlap);
    }
  }

  const granwave::ContactHistory &history = fix_history->history;
  if (history.size() > 0)
    for (int i = 0; i < nlocal; i++) {
      const DentRecord *record = history.records(i);
      for (int m = 0; m < history.count(i); m++, record++) {
        if (record->live) continue;
        const double between = effective_radius(radius[i], record->partner_radius);
        const ContactLaw &contact_law = law(type[i], record->partner_type);
        const ContactScale scale = contact_law.scale(between);
        double lost = 0.0, peak_force = 0.0;
        if (record->dent.peak > scale.elastic_limit) {
          const Turning turning = contact_law.turning(record->dent.peak / scale.overlap);
          lost = scale.force * scale.overlap * contact_law.dissipated_energy(turning);
          peak_force = scale.force * turning.force;
        }
        count(contact_law, scale, record->dent.peak, peak_force, lost, between, 0.5, history.past(i, m), 0.0);
      }
    }

  double all_largest = 0.0;
  MPI_Allreduce(&largest_force, &all_largest, 1, MPI_DOUBLE, MPI_MAX, world);
  pvector[LARGEST_FORCE] = comm->me == 0 ? all_largest : 0.0;    // compute pair adds up over processors
  if (!std::isfinite(elastic + pvector[DISSIPATED] + pvector[TANGENTIAL] + pvector[FRICTIONAL]))
    error->one(FLERR, "Pair style gran/hysteretic: the energy of the contacts is not a number: positions or velocities "
                      "are wrong, or the timestep is far too large");
  return elastic;
}

void PairGranHysteretic::tell_past(const ContactPast &past, Report &report)
{
  report.tangential_force = tangential_force(past.spring);
  report.tangential_elastic = tangential_energy(past.spring);
  report.frictional_loss = past.spring.loss;
  report.initial = past.initial;
}

PairGranHysteretic::Report PairGranHysteretic::describe(int i, int j, int k, double rsq)
{
  const Pairing p = pairing(atom->type[i], atom->type[j], atom->radius[i], atom->radius[j]);
  const ContactLaw &contact_law = *p.law;
  Report report{};
  report.i = i;
  report.j = j;
  report.tag_i = atom->tag[i];
  report.tag_j = atom->tag[j];
  report.live = true;
  report.share_i = contact_law.share_of_first();
  report.effective_radius = p.effective_radius;
  report.overlap = p.sum_radii - std::sqrt(rsq);
  const ContactPast past = k >= 0 ? past_of(k, 1.0) : ContactPast();
  if (k >= 0) report.dent = dent_of(k);
  tell_past(past, report);
  const double peak = report.dent.peak, overlap = report.overlap > ROUNDING * p.sum_radii ? report.overlap : 0.0;
  const double reached = std::max(peak, overlap);    // a pair that was moved since the last step may be beyond its peak
  if (reached > p.scale.elastic_limit) {
    const Turning turning = contact_law.turning(reached / p.scale.overlap);
    const double unit = p.scale.force * p.scale.overlap;
    report.yielded = reached > past.initial;
    report.force = p.scale.force * (overlap >= reached ? turning.force : ContactLaw::unloading(overlap / p.scale.overlap, turning));
    report.peak_force = p.scale.force * turning.force;
    report.elastic = unit * ContactLaw::elastic_energy(overlap / p.scale.overlap, turning);
    if (report.yielded)
      report.dissipated = unit * contact_law.dissipated_energy(turning) - lost_before(past.initial, p.scale, contact_law);
  } else {
    report.force = p.scale.hertz * overlap * std::sqrt(overlap);
    report.peak_force = p.scale.hertz * reached * std::sqrt(reached);
    report.elastic = 0.4 * report.force * overlap;
  }
  if (pasts) report.peak_force = force_reached(past, {reached}, overlap, p.scale, contact_law);
  return report;
}

void PairGranHysteretic::for_each_dent(const std::function<void(const Report &)> &visit)
{
  require_contacts();
  granwave::require_finite_motion(lmp);
  const double *const *x = atom->x;
  Contacts &c = contacts;
  for (std::size_t r = 0; r < c.row.size(); r++) {
    const int i = c.row[r];
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      if (c.peak[k] == 0.0) continue;
      const int j = c.partner[k];
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
      visit(describe(i, j, k, dx * dx + dy * dy + dz * dz));
    }
  }
  const granwave::ContactHistory &history = fix_history->history;
  for (int i = 0; i < atom->nlocal; i++) {
    const DentRecord *record = history.records(i);
    for (int m = 0; m < history.count(i); m++, record++) {
      if (record->live) continue;
      const ContactLaw &contact_law = law(atom->type[i], record->partner_type);
      Report report{};
      report.i = i;
      report.j = -1;
      report.tag_i = atom->tag[i];
      report.tag_j = static_cast<tagint>(record->partner);
      report.share_i = contact_law.share_of_first();
      report.effective_radius = effective_radius(atom->radius[i], record->partner_radius);
      const ContactPast past = history.past(i, m);
      report.dent = record->dent;
      tell_past(past, report);
      report.overlap = -gap;
      const ContactScale scale = contact_law.scale(report.effective_radius);
      if (record->dent.peak > scale.elastic_limit) {
        const Turning turning = contact_law.turning(record->dent.peak / scale.overlap);
        report.yielded = record->dent.peak > past.initial;
        report.peak_force = scale.force * turning.force;
        if (report.yielded)
          report.dissipated = scale.force * scale.overlap * contact_law.dissipated_energy(turning) -
              lost_before(past.initial, scale, contact_law);
      } else {
        report.peak_force = scale.hertz * record->dent.peak * std::sqrt(record->dent.peak);
      }
      if (pasts) report.peak_force = force_reached(past, record->dent, 0.0, scale, contact_law);
      visit(report);
    }
  }
}

void PairGranHysteretic::visit_pair(tagint one, tagint other, const std::function<void(const Report &)> &visit)
{
  require_contacts();
  const double *const *x = atom->x;
  const Contacts &c = contacts;
  for (std::size_t r = 0; r < c.row.size(); r++) {
    if (c.row_tag[r] != one && c.row_tag[r] != other) continue;
    const tagint wanted = c.row_tag[r] == one ? other : one;
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      if (c.partner_tag[k] != wanted) continue;
      const int i = c.row[r], j = c.partner[k];
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
      visit(describe(i, j, k, dx * dx + dy * dy + dz * dz));
    }
  }
}

double PairGranHysteretic::single(int i, int j, int, int, double rsq, double, double, double &fforce)
{
  require_contacts();
  const Contacts &c = contacts;
  int found = -1;
  for (const auto &[a, b] : {std::pair<int, int>{i, j}, {j, i}}) {
    if (a >= static_cast<int>(c.row.size()) || found >= 0) continue;
    // rows follow the list of owned spheres, which is the identity unless the style shares the system with others
    std::size_t r = a;
    if (c.row[r] != a) r = std::find(c.row.begin(), c.row.end(), a) - c.row.begin();
    if (r == c.row.size()) continue;
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++)
      if (c.partner[k] == b || c.partner_tag[k] == atom->tag[b]) found = k;
  }
  const Report report = describe(i, j, found, rsq);
  svector[OVERLAP] = report.overlap;
  svector[PEAK_OVERLAP] = report.dent.peak;
  svector[PEAK_FORCE] = report.peak_force;
  svector[LOST] = report.dissipated;
  svector[TIME_FIRST] = report.dent.time_first;
  svector[TIME_PEAK] = report.dent.time_peak;
  svector[TIME_YIELD] = report.dent.time_yield;
  fforce = report.force / std::sqrt(rsq);
  return report.elastic;
}
