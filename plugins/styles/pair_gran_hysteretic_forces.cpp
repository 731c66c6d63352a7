// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: forces. */

#include "pair_gran_hysteretic.h"

#include "atom.h"
#include "error.h"
#include "finite_motion.h"
#include "fix_gran_hysteretic_history.h"
#include "simulated_time.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

using namespace LAMMPS_NS;
using granwave::ScaledLaw;
using granwave::TangentialSpring;
using granwave::TwofoldSum;

/* Turning point of a contact that has yielded, recomputed if its history has changed. */

int PairGranHysteretic::cached_turning(int k, const ScaledLaw &contact)
{
  Contacts &c = contacts;
  if (c.turning[k] < 0) {
    c.turning[k] = static_cast<int>(c.turnings.size());
    c.turnings.push_back({-1.0, 0.0, 0.0, 0.0});
    c.work_lost.push_back(0.0);
    if (has_friction) c.circle.push_back(0.0);
  }
  const int t = c.turning[k];
  const double peak = contact.normalised(c.peak[k]);
  if (c.turnings[t].peak != peak) {
    c.turnings[t] = contact.turning(law_history(k));
    c.work_lost[t] = -1.0;
    if (has_friction) c.circle[t] = contact.law().area(peak);
  }
  return t;
}

/* Force of a contact beyond its elastic limit, on loading (the peak has just been increased) or below its peak. */

double PairGranHysteretic::plastic_force(int k, double overlap, const ScaledLaw &contact, bool raised)
{
  if (raised) {
    if (contacts.time_yield[k] < 0.0) contacts.time_yield[k] = now;
    return contact.loading_beyond_yield(overlap, law_history(k).extra);
  }
  return contact.unloading(overlap, contacts.turnings[cached_turning(k, contact)]);
}

/* Squared present radius of the contact circle of a contact beyond its elastic limit. */

double PairGranHysteretic::circle_squared(int k, double overlap, const ScaledLaw &contact)
{
  if (overlap >= contacts.peak[k]) return contact.loading_circle(overlap);
  const int t = cached_turning(k, contact);
  return contact.unloading_circle(overlap, contacts.turnings[t], contacts.circle[t]);
}

inline void PairGranHysteretic::release_spring(int k)
{
  release(contacts.spring[k]);
  contacts.has_spring[k] = 0;
}

/* True if any contact of a row has a spring. Eight flags are read at a time, so those of the next row may be included. */

inline bool PairGranHysteretic::any_spring(int begin, int end) const
{
  std::uint64_t any = 0, eight;
  for (int k = begin; k < end; k += FLAGS_AT_A_TIME) {
    std::memcpy(&eight, contacts.has_spring.data() + k, FLAGS_AT_A_TIME);
    any |= eight;
  }
  return any != 0;
}

/* Increase the largest overlap of this run, which may be smaller than the initial dent. */

inline void PairGranHysteretic::raise_reached(int k, double overlap)
{
  Contacts &c = contacts;
  if (c.time_first[k] < 0.0) c.time_first[k] = now;
  c.reached[k] = overlap;
  c.time_peak[k] = now;
}

inline void PairGranHysteretic::Batch::set(int m, const PairParameters &p)
{
  pair[m] = &p;
  radius_i[m] = p.radius_i;
  radius_j[m] = p.radius_j;
  radsum[m] = p.radsum;
  effective_radius[m] = p.contact.effective_radius();
  hertz[m] = p.contact.hertz();
  shear_stiffness[m] = p.shear_stiffness;
  keeps[m] = p.tangential_model == granwave::TangentialModel::MINDLIN ? 1.0 : 0.0;
}

/* Update the history of touching pairs, and the forces of those that have yielded. */

void PairGranHysteretic::update_history(Batch &batch)
{
  Contacts &c = contacts;
  for (int m = 0; m < batch.size; m++) {
    const int k = batch.k[m];
    const PairParameters &p = *batch.pair[m];
    const double overlap = batch.overlap[m];
    if (!(overlap <= p.largest_overlap)) overlap_error(batch.i[m], batch.j[m], overlap);
    if (c.n_extra > 0 && p.contact.update(overlap, c.peak[k], c.extra.data() + std::size_t(k) * c.n_extra) &&
        c.turning[k] >= 0)
      c.turnings[c.turning[k]].peak = -1.0;    // invalid after a change of history
    const bool raised = overlap > c.peak[k];
    if (raised) {
      if (c.peak[k] == 0.0) c.time_first[k] = now;
      c.peak[k] = overlap;
      c.time_peak[k] = now;
    }
    if (has_initial_dents && overlap > c.reached[k]) raise_reached(k, overlap);
    if (!p.contact.yielded(c.peak[k])) continue;
    batch.force[m] = plastic_force(k, overlap, p.contact, raised);
    if (has_friction) batch.circle[m] = circle_squared(k, overlap, p.contact);
  }
}

/* Advance the tangential springs of touching pairs and compute the forces on the spheres, including friction. */

void PairGranHysteretic::compute_tangential(Batch &batch)
{
  Contacts &c = contacts;
  const double *const v = atom->v[0], *const omega = atom->omega[0];    // contiguous
  for (int m = 0; m < batch.size; m++) {
    const int k = batch.k[m], i = 3 * batch.i[m], j = 3 * batch.j[m];
    batch.limit[m] = std::max(batch.pair[m]->friction * batch.force[m], 0.0);
    if (batch.limit[m] == 0.0) {
      if (c.has_spring[k]) release_spring(k);
      batch.circle[m] = 1.0;    // any value, for a pair without friction
    }
    const TangentialSpring &spring = c.spring[k];
    for (int d = 0; d < 3; d++) {
      batch.velocity[d][m] = v[i + d] - v[j + d];
      batch.omega_i[d][m] = omega[i + d];
      batch.omega_j[d][m] = omega[j + d];
      batch.tangential[d][m] = spring.force[d];
    }
    batch.compliance[m] = spring.compliance;
    batch.loss[m] = spring.loss;
  }
  if (springs_advance) {
    batch.compute_tangential(update->dt);
    for (int m = 0; m < batch.size; m++) {
      if (batch.limit[m] == 0.0) continue;
      c.spring[batch.k[m]] = {
          {batch.tangential[0][m], batch.tangential[1][m], batch.tangential[2][m]}, batch.compliance[m], batch.loss[m]};
      c.has_spring[batch.k[m]] = 1;
    }
  }
  batch.compute_forces_and_torques();
  accumulate(batch, torque_sums, batch.torque_i, batch.torque_j);
}

void PairGranHysteretic::tally(const Batch &batch, Tally what)
{
  const int nlocal = atom->nlocal;
  for (int m = 0; m < batch.size; m++) {
    const double delx = batch.del[0][m], dely = batch.del[1][m], delz = batch.del[2][m];
    const double fx = batch.force_i[0][m], fy = batch.force_i[1][m], fz = batch.force_i[2][m];
    if (what == Tally::VIRIAL) {
      const double share = batch.j[m] < nlocal ? 1.0 : 0.5;
      virial[0] += share * delx * fx;
      virial[1] += share * dely * fy;
      virial[2] += share * delz * fz;
      virial[3] += share * delx * fy;
      virial[4] += share * delx * fz;
      virial[5] += share * dely * fz;
      continue;
    }
    const PairParameters &p = *batch.pair[m];
    const double peak = contacts.peak[batch.k[m]], overlap = batch.overlap[m];
    double elastic = 0.4 * batch.force[m] * overlap;
    if (p.contact.yielded(peak))
      elastic = p.contact.elastic_energy(overlap, contacts.turnings[cached_turning(batch.k[m], p.contact)]);
    ev_tally_xyz(batch.i[m], batch.j[m], nlocal, 0, elastic, 0.0, fx, fy, fz, delx, dely, delz);
  }
}

/* Add the forces to the sums of both spheres. Pairs of one row are consecutive. */

void PairGranHysteretic::accumulate(const Batch &batch, granwave::TwofoldSums &sums,
                                    const double (&on_i)[3][Batch::CAPACITY], const double (&on_j)[3][Batch::CAPACITY])
{
  const int nlocal = atom->nlocal;
  for (int m = 0; m < batch.size;) {
    const int i = batch.i[m];
    TwofoldSum sum = sums[i];
    for (; m < batch.size && batch.i[m] == i; m++) {
      sum.add(on_i[0][m], on_i[1][m], on_i[2][m]);
      if (batch.j[m] < nlocal) sums[batch.j[m]].add(on_j[0][m], on_j[1][m], on_j[2][m]);
    }
    sums[i] = sum;
  }
}

/* Compute forces and history of a batch of touching pairs. */

void PairGranHysteretic::compute_batch(Batch &batch, Tally what)
{
  batch.compute_overlap();
  update_history(batch);
  if (has_friction) compute_tangential(batch);
  else batch.compute_normal();
  accumulate(batch, force_sums, batch.force_i, batch.force_j);
  if (what != Tally::NONE) tally(batch, what);
  batch.size = 0;
}

template <bool UNIFORM> void PairGranHysteretic::compute_forces(Tally what)
{
  constexpr int ROWS_AT_A_TIME = 64;    // since only few pairs touch in a packing at rest
  const double (*const x)[3] = reinterpret_cast<const double (*)[3]>(atom->x[0]);
  const double *const v = atom->v[0], *const omega =
                                          has_friction ? atom->omega[0] : nullptr;    // contiguous, as the arrays below
  double *const f = atom->f[0], *const torque = has_friction ? atom->torque[0] : nullptr;
  const double *const radius = atom->radius;
  const int *const type = atom->type;
  const int nlocal = atom->nlocal;
  Contacts &c = contacts;
  const int rows = static_cast<int>(c.row.size());
  const int *const partner = c.partner.data();
  const double *const peak = c.peak.data();
  force_sums.reserve(c.ordered ? c.span + ROWS_AT_A_TIME : nlocal);
  if (has_friction) torque_sums.reserve(c.ordered ? c.span + ROWS_AT_A_TIME : nlocal);
  const auto add_forces = [&](int i) {
    force_sums.give(i, f + 3 * i);
    if (has_friction) torque_sums.give(i, torque + 3 * i);
  };

  Batch batch;
  PairParameters parameters[Batch::CAPACITY];
  double touch_sq = 0.0, forget_sq = 0.0;
  if (UNIFORM) {
    parameters[0] = pair_parameters(type[0], type[0], radius[0], radius[0]);
    touch_sq = parameters[0].touch_sq;
    forget_sq = (parameters[0].radsum + gap) * (parameters[0].radsum + gap);
  }

  int set = 0;     // number of pairs of the batch whose parameters are set, if all spheres are equal
  int done = 0;    // number of rows whose spheres have their forces
  const auto compute_up_to = [&](int row) {
    if (batch.size > 0) compute_batch(batch, what);
    for (; done < row; done++)
      if (c.ordered) add_forces(c.row[done]);
  };
  for (int r = 0; r < rows; r++) {
    const int i = c.row[r], end = c.begin[r + 1];
    const double xi = x[i][0], yi = x[i][1], zi = x[i][2];
    const bool springs = has_friction && any_spring(c.begin[r], end);
    for (int k = c.begin[r]; k < end; k++) {
      const int j = partner[k];
      const double delx = xi - x[j][0], dely = yi - x[j][1], delz = zi - x[j][2];
      const double rsq = delx * delx + dely * dely + delz * delz;
      if (!UNIFORM) {
        const double sum = radius[i] + radius[j];
        touch_sq = touch_squared(sum);
        forget_sq = (sum + gap) * (sum + gap);
      }
      if (rsq >= touch_sq) {
        if (springs && c.has_spring[k]) release_spring(k);
        if (rsq > forget_sq && peak[k] > 0.0) forget(r, k);
        continue;
      }
      const int m = batch.size++;
      batch.k[m] = k;
      batch.i[m] = i;
      batch.j[m] = j;
      batch.del[0][m] = delx;
      batch.del[1][m] = dely;
      batch.del[2][m] = delz;
      batch.rsq[m] = rsq;
      if (has_friction) {    // prefetch while the next pairs are checked
        __builtin_prefetch(&c.spring[k], 1);
        __builtin_prefetch(v + 3 * j);
        __builtin_prefetch(omega + 3 * j);
      }
      if (!UNIFORM) {
        parameters[m] = pair_parameters(type[i], type[j], radius[i], radius[j]);
        batch.set(m, parameters[m]);
      } else if (m == set) {
        batch.set(set++, parameters[0]);
      }
      if (batch.size == Batch::CAPACITY) compute_up_to(r);
    }
    if (r + 1 - done >= ROWS_AT_A_TIME) compute_up_to(r + 1);
  }
  compute_up_to(rows);
  if (!c.ordered)
    for (int i = 0; i < nlocal; i++) add_forces(i);
}

void PairGranHysteretic::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (evaluations++ % STEPS_BETWEEN_CHECKS == 0) granwave::require_finite_motion(lmp);
  if (!contacts.valid) build_contacts();
  contacts.published = false;
  now = granwave::simulated_time(*update);
  // springs are not updated in a setup, so that a continued run is identical to an uninterrupted one
  springs_advance = update->whichflag == 1 && !update->setupflag;

  // LAMMPS requests the pressure more often than it is used: its cost must be negligible
  const Tally what = eflag_atom || vflag_atom || cvflag_atom || num_tally_compute > 0 ? Tally::EACH_PAIR
                     : vflag_global                                                   ? Tally::VIRIAL
                                                                                      : Tally::NONE;
  if (atom->nlocal > 0) uniform ? compute_forces<true>(what) : compute_forces<false>(what);
  if (eflag_global) eng_vdwl = tally_totals();
}

void PairGranHysteretic::overlap_error(int i, int j, double overlap)
{
  for (const int sphere : {i, j}) granwave::require_finite_motion(lmp, sphere);
  const bool face = atom->radius[i] == 0.0 || atom->radius[j] == 0.0;
  error->one(FLERR,
             fmt::format("Spheres {} and {} overlap by {:.3g}, more than {}: they were placed into each other, or the "
                         "timestep is far too large",
                         atom->tag[i], atom->tag[j], overlap,
                         face ? "half the radius of the one that meets a flat face" : "the radius of the smaller one"));
}
