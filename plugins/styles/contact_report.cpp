// SPDX-License-Identifier: GPL-2.0-only
#include "contact_report.h"

#include <algorithm>
#include <cmath>

namespace granwave {

namespace {

/* Time at which the force of a contact first exceeded a fraction of its largest force in this run, without viscous forces
   and the pull of cohesion; -1 = never. */
double arrival(const ContactMemory &has, const ScaledLaw &contact, const Dent &dent, const BlockView &view)
{
  const double largest = has.dents ? view.reached : dent.peak;
  if (!(largest > 0.0)) return -1.0;
  const double there = contact.overlap_at_part(largest, ARRIVED, view.extra, {view.initial, view.initial_extra});
  return dent.front.passed(largest, there / largest);
}

}    // namespace

double largest_force_of_run(const ContactMemory &has, const ScaledLaw &contact, const LawHistory &h, const BlockView &view,
                            double overlap, double at_peak)
{
  const double viscous = has.loss_of(h.extra).peak_force, reached = has.dents ? std::max(view.reached, overlap) : h.peak;
  if (viscous > 0.0) return viscous - (contact.cohesive() ? contact.pull_off() : 0.0);
  if (contact.cohesive()) return std::max(contact.cohesive_state(reached, h).force, 0.0);
  if (!has.dents) return at_peak;
  if (!contact.yielded(h.peak)) return reached > 0.0 ? contact.elastic_force(reached) : 0.0;
  return reached >= h.peak ? contact.loading_beyond_yield(reached, h.extra) : contact.unloading(reached, contact.turning(h));
}

int beyond_range(const ScaledLaw &contact, double peak)
{
  if (!contact.is_hertzian()) return peak > contact.valid_overlap() ? 2 : peak > 0.5 * contact.valid_overlap() ? 1 : 0;
  if (!contact.yielded(peak) || !contact.law().entry().fitted) return 0;
  return peak > 0.2 * contact.effective_radius() ? 2 : peak > 0.1 * contact.effective_radius() ? 1 : 0;
}

void fill_report(ContactReport &report, const ContactMemory &has, const ScaledLaw &contact, const BlockView &view,
                 double overlap)
{
  report.share_i = contact.law().share_of_first();
  report.effective_radius = contact.effective_radius();
  const double *const damping = has.damping_of(view.extra);
  for (int d = 0; d < 3; d++)
    report.tangential[d] = view.spring.force[d] + view.side * (damping ? damping[DampingHistory::FORCE + d] : 0.0);
  report.tangential_force = std::sqrt(dot(report.tangential, report.tangential));
  report.tangential_elastic = has.tangential_energy(view.spring, view.extra);
  report.frictional_loss = view.spring.loss;
  report.initial = view.initial;
  const ViscousHistory viscous = has.loss_of(view.extra);
  report.viscous_loss = has.viscous_loss(view.extra);
  if (has.resistance) {
    const ResistanceHistory resisted = has.resistance_of(view.extra);
    report.rolling_loss = resisted.rolling.loss;
    report.twisting_loss = resisted.twisting.loss;
    report.tangential_elastic += resisted.stored();
    report.frictional_loss += resisted.loss();
  }
  // a pair that was moved since the last step may be beyond its peak
  const LawHistory h{std::max(report.dent.peak, overlap), view.extra};
  if (contact.yielded(h.peak)) {
    const Turning turning = contact.turning(h);
    report.yielded = h.peak > view.initial;
    report.peak_force = contact.peak_force(turning);
    if (overlap > 0.0) report.force = overlap >= h.peak ? report.peak_force : contact.unloading(overlap, turning);
    report.elastic = has.stored_energy(contact, overlap, h, &turning);
    if (report.yielded)
      report.dissipated =
          contact.dissipated_energy(turning, h.extra) - contact.dissipated_energy({view.initial, view.initial_extra});
  } else {
    report.force = contact.elastic_force(overlap);
    report.peak_force = contact.elastic_force(h.peak);
    report.elastic = has.stored_energy(contact, overlap, h);
  }
  report.peak_force = largest_force_of_run(has, contact, h, view, overlap, report.peak_force);
  report.time_first = report.peak_force > 0.0 ? arrival(has, contact, report.dent, view) : -1.0;
  report.touches = report.force > 0.0;
  if (contact.cohesive()) {
    const CohesionHistory history = has.cohesion_of(view.extra);
    report.touches = history.joined > 0.0;
    report.force = report.touches ? contact.cohesive_state(overlap, h).force : 0.0;
    report.adhesive_loss = history.lost;
  }
  if (overlap > 0.0 || report.touches) report.force += viscous.force;
}

}    // namespace granwave
