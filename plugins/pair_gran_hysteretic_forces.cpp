/* Pair style gran/hysteretic: forces. */

#include "pair_gran_hysteretic.h"

#include "atom.h"
#include "error.h"
#include "fix_gran_hysteretic_history.h"
#include "simulated_time.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using granwave::ContactLaw;
using granwave::ContactScale;
using granwave::Spring;
using granwave::Turning;

int PairGranHysteretic::turning_of(int k, double peak, const ContactLaw &contact_law)
{
  Contacts &c = contacts;
  if (c.turning[k] < 0) {
    c.turning[k] = static_cast<int>(c.turnings.size());
    c.turnings.push_back({-1.0, 0.0, 0.0, 0.0});
    c.work_lost.push_back(0.0);
    if (rubbing) c.circle.push_back(0.0);
  }
  const int t = c.turning[k];
  if (c.turnings[t].peak != peak) {
    c.turnings[t] = contact_law.turning(peak);
    c.work_lost[t] = -1.0;
    if (rubbing) c.circle[t] = contact_law.area(peak);
  }
  return t;
}

/* A contact beyond its elastic limit, loading (the peak was raised just now) or below its peak. */

double PairGranHysteretic::yielding_force(int k, double overlap, const ContactLaw &contact_law, const ContactScale &scale,
                                          bool raised)
{
  if (raised) {
    if (contacts.time_yield[k] < 0.0) contacts.time_yield[k] = now;
    return scale.force * contact_law.loading(overlap / scale.overlap);
  }
  const Turning &turning = contacts.turnings[turning_of(k, contacts.peak[k] / scale.overlap, contact_law)];
  return scale.force * ContactLaw::unloading(overlap / scale.overlap, turning);
}

/* Radius of the contact circle now, squared. */

double PairGranHysteretic::circle_squared(int k, double overlap, const Geometry &g, const ContactLaw &contact_law)
{
  const double peak = contacts.peak[k];
  if (peak <= g.scale.elastic_limit) return g.effective_radius * overlap;
  const double a = overlap / g.scale.overlap, unit = g.effective_radius * g.scale.overlap;
  if (overlap >= peak) return unit * contact_law.area(a);
  const int t = turning_of(k, peak / g.scale.overlap, contact_law);
  return unit * ContactLaw::unloading_area(a, contacts.turnings[t], contacts.circle[t]);
}

/* The forces on a sphere are added up in whatever order the list has, which differs with the number of processors. Twice
   the precision makes the sum, once rounded, the same in any order: a run gives the same bits on any number of ranks. */

inline void PairGranHysteretic::Sum::add(const double (&term)[3])
{
  for (int d = 0; d < 3; d++) {
    const double total = high[d] + term[d], rounded = total - high[d];
    low[d] += (high[d] - (total - rounded)) + (term[d] - rounded);    // Knuth: what the addition lost
    high[d] = total;
  }
}

inline void PairGranHysteretic::let_go(int k)
{
  release(contacts.spring[k]);
  contacts.held[k] = 0;
}

/* The tangential force of a contact, added to what pushes sphere i, and its torques. */

inline void PairGranHysteretic::rub(int k, int i, int j, double overlap, double distance, const double (&apart)[3],
                                    double normal_force, const Geometry &g, double (&push)[3])
{
  const double *const radius = atom->radius;
  const int *const type = atom->type;
  Spring &spring = contacts.spring[k];
  const double mu = radius[i] > 0.0 && radius[j] > 0.0 ? friction(type[i], type[j]) : 0.0;
  if (normal_force <= 0.0 || mu == 0.0) {
    if (contacts.held[k]) let_go(k);
    return;
  }
  const double inverse = 1.0 / distance, n[3] = {apart[0] * inverse, apart[1] * inverse, apart[2] * inverse};
  const double lever_i = radius[i] - 0.5 * overlap, lever_j = radius[j] - 0.5 * overlap;
  if (slips) {
    const double *const v = atom->v[0], *const omega = atom->omega[0];    // contiguous
    const double *const vi = v + 3 * i, *const vj = v + 3 * j, *const wi = omega + 3 * i, *const wj = omega + 3 * j;
    const double velocity[3] = {vi[0] - vj[0], vi[1] - vj[1], vi[2] - vj[2]};
    double spin[3], slip[3];
    for (int d = 0; d < 3; d++) spin[d] = lever_i * wi[d] + lever_j * wj[d];
    granwave::slip_of_step(velocity, spin, n, update->dt, slip);
    const ContactLaw &contact_law = law(type[i], type[j]);
    const double stiffness = contact_law.tangential_stiffness(circle_squared(k, overlap, g, contact_law));
    granwave::advance(spring, n, slip, stiffness, mu * normal_force, grip(type[i], type[j]));
    contacts.held[k] = 1;
  }
  double twist[3], moment[3];
  granwave::torque_per_lever(n, spring.force, twist);
  for (int d = 0; d < 3; d++) push[d] += spring.force[d];
  for (int d = 0; d < 3; d++) moment[d] = lever_i * twist[d];
  torque_sums[i].add(moment);
  if (j >= atom->nlocal) return;
  for (int d = 0; d < 3; d++) moment[d] = lever_j * twist[d];
  torque_sums[j].add(moment);
}

inline void PairGranHysteretic::give_torque(int i)
{
  if (!rubbing) return;
  Sum &sum = torque_sums[i];
  double any = 0.0;
  for (int d = 0; d < 3; d++) any += std::fabs(sum.high[d]) + std::fabs(sum.low[d]);
  if (any == 0.0) return;
  for (int d = 0; d < 3; d++) atom->torque[i][d] += sum.high[d] + sum.low[d];
  sum = Sum{};
}

/* The largest overlap of this run, which may be less than the dent from before it. */

inline void PairGranHysteretic::reach(int k, double overlap)
{
  Contacts &c = contacts;
  if (c.time_first[k] < 0.0) c.time_first[k] = now;
  c.reached[k] = overlap;
  c.time_peak[k] = now;
}

template <bool UNIFORM, PairGranHysteretic::Tally TALLY, bool EXTRAS> void PairGranHysteretic::forces()
{
  const double(*const x)[3] = reinterpret_cast<const double(*)[3]>(atom->x[0]);
  double(*const f)[3] = reinterpret_cast<double(*)[3]>(atom->f[0]);
  const double *const radius = atom->radius;
  const int *const type = atom->type;
  const int nlocal = atom->nlocal;
  Contacts &c = contacts;
  const int rows = static_cast<int>(c.row.size());
  const int *const partner = c.partner.data();
  double *const peak = c.peak.data();
  force_sums.resize(nlocal);    // all zero between force evaluations
  Sum *const sums = force_sums.data();
  if constexpr (EXTRAS)
    if (rubbing) torque_sums.resize(nlocal);
  const auto give = [&](int i) {
    for (int d = 0; d < 3; d++) f[i][d] += sums[i].high[d] + sums[i].low[d];
    sums[i] = Sum{};
    if constexpr (EXTRAS) give_torque(i);
  };

  Geometry g{};
  double forget_sq = 0.0, largest = 0.0, sum[6] = {};
  if (UNIFORM) {
    g = geometry(type[0], type[0], radius[0], radius[0]);
    forget_sq = (g.sum_radii + gap) * (g.sum_radii + gap);
    largest = radius[0];
  }

  for (int r = 0; r < rows; r++) {
    const int i = c.row[r];
    const double xi = x[i][0], yi = x[i][1], zi = x[i][2];
    Sum total = sums[i];
    const int end = c.begin[r + 1];
    for (int k = c.begin[r]; k < end; k++) {
      const int j = partner[k];
      const double dx = xi - x[j][0], dy = yi - x[j][1], dz = zi - x[j][2];
      const double rsq = dx * dx + dy * dy + dz * dz;
      if (!UNIFORM) {
        const double sum = radius[i] + radius[j];
        g.sum_radii = sum;
        g.touch_sq = sum * sum * (1.0 - 2.0 * ROUNDING);
        forget_sq = (sum + gap) * (sum + gap);
      }
      if (rsq >= g.touch_sq) {
        if constexpr (EXTRAS)
          if (c.held[k]) let_go(k);
        if (rsq > forget_sq && peak[k] > 0.0) forget(r, k);
        continue;
      }
      if (!UNIFORM) {
        g.effective_radius = effective_radius(radius[i], radius[j]);
        g.scale = law(type[i], type[j]).scale(g.effective_radius);
        largest = largest_overlap(radius[i], radius[j]);
      }
      const double distance = std::sqrt(rsq);
      const double overlap = g.sum_radii - distance;
      double peak_overlap = peak[k];
      const bool raised = overlap > peak_overlap;
      if (raised) {
        if (peak_overlap == 0.0) c.time_first[k] = now;
        peak[k] = peak_overlap = overlap;
        c.time_peak[k] = now;
      }
      if constexpr (EXTRAS)
        if (pasts && overlap > c.reached[k]) reach(k, overlap);
      double normal_force;
      if (peak_overlap <= g.scale.elastic_limit) {
        if (overlap > largest) overlap_error(i, j, overlap);
        normal_force = g.scale.hertz * overlap * std::sqrt(overlap);
      } else {
        if (overlap > largest) overlap_error(i, j, overlap);
        normal_force = yielding_force(k, overlap, law(type[i], type[j]), g.scale, raised);
      }
      const double pair_force = normal_force / distance;
      double push[3] = {dx * pair_force, dy * pair_force, dz * pair_force};
      if constexpr (EXTRAS)
        if (rubbing) rub(k, i, j, overlap, distance, {dx, dy, dz}, normal_force, g, push);
      const double back[3] = {-push[0], -push[1], -push[2]};
      total.add(push);
      if (j < nlocal) sums[j].add(back);
      if (TALLY == Tally::PRESSURE) {
        if constexpr (EXTRAS) {
          const double share = j < nlocal ? 1.0 : 0.5;
          sum[0] += dx * push[0] * share;
          sum[1] += dy * push[1] * share;
          sum[2] += dz * push[2] * share;
          sum[3] += dx * push[1] * share;
          sum[4] += dx * push[2] * share;
          sum[5] += dy * push[2] * share;
          continue;
        }
        const double share = j < nlocal ? pair_force : 0.5 * pair_force;
        sum[0] += dx * dx * share;
        sum[1] += dy * dy * share;
        sum[2] += dz * dz * share;
        sum[3] += dx * dy * share;
        sum[4] += dx * dz * share;
        sum[5] += dy * dz * share;
      } else if (TALLY == Tally::EACH_PAIR) {
        double elastic = 0.0;
        if (eflag_either) {
          if (peak_overlap <= g.scale.elastic_limit) {
            elastic = 0.4 * normal_force * overlap;
          } else {
            const ContactLaw &contact_law = law(type[i], type[j]);
            const Turning &turning = c.turnings[turning_of(k, peak_overlap / g.scale.overlap, contact_law)];
            elastic = g.scale.force * g.scale.overlap * ContactLaw::elastic_energy(overlap / g.scale.overlap, turning);
          }
        }
        if constexpr (EXTRAS)
          ev_tally_xyz(i, j, nlocal, 0, elastic, 0.0, push[0], push[1], push[2], dx, dy, dz);
        else
          ev_tally(i, j, nlocal, 0, elastic, 0.0, pair_force, dx, dy, dz);
      }
    }
    sums[i] = total;
    if (c.ordered) give(i);
  }
  if (!c.ordered)
    for (int i = 0; i < nlocal; i++) give(i);
  if (TALLY == Tally::PRESSURE)
    for (int k = 0; k < 6; k++) virial[k] += sum[k];
}

template <bool EXTRAS> void PairGranHysteretic::forces(Tally tally)
{
  if (tally == Tally::NOTHING)
    uniform ? forces<true, Tally::NOTHING, EXTRAS>() : forces<false, Tally::NOTHING, EXTRAS>();
  else if (tally == Tally::PRESSURE)
    uniform ? forces<true, Tally::PRESSURE, EXTRAS>() : forces<false, Tally::PRESSURE, EXTRAS>();
  else
    uniform ? forces<true, Tally::EACH_PAIR, EXTRAS>() : forces<false, Tally::EACH_PAIR, EXTRAS>();
}

void PairGranHysteretic::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (!contacts.valid) build_contacts();
  contacts.published = false;
  now = granwave::simulated_time(*update);
  // springs keep still where no time passes: a run that is set up anew goes on as if it had not been cut
  slips = update->whichflag == 1 && !update->setupflag;

  // LAMMPS asks for the pressure more often than anybody looks at it: it must cost next to nothing
  const Tally tally = eflag_atom || vflag_atom || cvflag_atom || num_tally_compute > 0 ? Tally::EACH_PAIR
      : vflag_global                                                                   ? Tally::PRESSURE
                                                                                       : Tally::NOTHING;
  if (atom->nlocal > 0) rubbing || pasts ? forces<true>(tally) : forces<false>(tally);
  if (eflag_global) eng_vdwl = tally_totals();
}

void PairGranHysteretic::overlap_error(int i, int j, double overlap)
{
  const bool face = atom->radius[i] == 0.0 || atom->radius[j] == 0.0;
  error->one(FLERR, fmt::format("Spheres {} and {} overlap by {:.3g}, more than {}: they were placed into each other, or the "
                                "timestep is far too large", atom->tag[i], atom->tag[j], overlap,
                                face ? "half the radius of the one that meets a flat face" : "the radius of the smaller one"));
}

