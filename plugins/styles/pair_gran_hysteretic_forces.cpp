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
using granwave::ContactLaw;
using granwave::Spring;
using granwave::Turning;
using granwave::TwofoldSum;

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

double PairGranHysteretic::yielding_force(int k, double overlap, const Pairing &p, bool raised)
{
  if (raised) {
    if (contacts.time_yield[k] < 0.0) contacts.time_yield[k] = now;
    return p.scale.force * p.law->loading(overlap / p.scale.overlap);
  }
  const Turning &turning = contacts.turnings[turning_of(k, contacts.peak[k] / p.scale.overlap, *p.law)];
  return p.scale.force * ContactLaw::unloading(overlap / p.scale.overlap, turning);
}

/* Radius of the contact circle now, squared. */

double PairGranHysteretic::circle_squared(int k, double overlap, const Pairing &p)
{
  const double peak = contacts.peak[k];
  if (peak <= p.scale.elastic_limit) return p.effective_radius * overlap;
  const double a = overlap / p.scale.overlap, unit = p.effective_radius * p.scale.overlap;
  if (overlap >= peak) return unit * p.law->area(a);
  const int t = turning_of(k, peak / p.scale.overlap, *p.law);
  return unit * ContactLaw::unloading_area(a, contacts.turnings[t], contacts.circle[t]);
}

inline void PairGranHysteretic::let_go(int k)
{
  release(contacts.spring[k]);
  contacts.held[k] = 0;
}

/* Whether any contact of a row holds a spring; eight at a time, so one of the next row may count too. */

inline bool PairGranHysteretic::any_held(int begin, int end) const
{
  std::uint64_t held = 0, eight;
  for (int k = begin; k < end; k += HELD_AT_A_TIME) {
    std::memcpy(&eight, contacts.held.data() + k, HELD_AT_A_TIME);
    held |= eight;
  }
  return held != 0;
}

/* The largest overlap of this run, which may be less than the dent from before it. */

inline void PairGranHysteretic::reach(int k, double overlap)
{
  Contacts &c = contacts;
  if (c.time_first[k] < 0.0) c.time_first[k] = now;
  c.reached[k] = overlap;
  c.time_peak[k] = now;
}

inline void PairGranHysteretic::Touch::set(int m, const Pairing &p)
{
  pairing[m] = &p;
  radius_i[m] = p.radius_i;
  radius_j[m] = p.radius_j;
  sum_radii[m] = p.sum_radii;
  effective_radius[m] = p.effective_radius;
  hertz[m] = p.scale.hertz;
  shear_stiffness[m] = p.shear_stiffness;
  keeps[m] = p.grip == granwave::Grip::KEPT ? 1.0 : 0.0;
}

/* The memory of those that touch: new peaks, and the forces of those that have yielded. */

void PairGranHysteretic::remember(Touch &touch)
{
  Contacts &c = contacts;
  for (int m = 0; m < touch.size; m++) {
    const int k = touch.k[m];
    const Pairing &p = *touch.pairing[m];
    const double overlap = touch.overlap[m];
    if (!(overlap <= p.largest_overlap)) overlap_error(touch.i[m], touch.j[m], overlap);
    const bool raised = overlap > c.peak[k];
    if (raised) {
      if (c.peak[k] == 0.0) c.time_first[k] = now;
      c.peak[k] = overlap;
      c.time_peak[k] = now;
    }
    if (pasts && overlap > c.reached[k]) reach(k, overlap);
    if (c.peak[k] <= p.scale.elastic_limit) continue;
    touch.force[m] = yielding_force(k, overlap, p, raised);
    if (rubbing) touch.circle[m] = circle_squared(k, overlap, p);
  }
}

/* Friction of those that touch. */

void PairGranHysteretic::rub(Touch &touch)
{
  Contacts &c = contacts;
  const double *const v = atom->v[0], *const omega = atom->omega[0];    // contiguous
  for (int m = 0; m < touch.size; m++) {
    const int k = touch.k[m], i = 3 * touch.i[m], j = 3 * touch.j[m];
    touch.limit[m] = std::max(touch.pairing[m]->friction * touch.force[m], 0.0);
    if (touch.limit[m] == 0.0) {
      if (c.held[k]) let_go(k);
      touch.circle[m] = 1.0;    // may be none, and nothing comes of it
    }
    const Spring &spring = c.spring[k];
    for (int d = 0; d < 3; d++) {
      touch.velocity[d][m] = v[i + d] - v[j + d];
      touch.omega_i[d][m] = omega[i + d];
      touch.omega_j[d][m] = omega[j + d];
      touch.held[d][m] = spring.force[d];
    }
    touch.compliance[m] = spring.compliance;
    touch.loss[m] = spring.loss;
  }
  if (slips) {
    touch.slide(update->dt);
    for (int m = 0; m < touch.size; m++) {
      if (touch.limit[m] == 0.0) continue;
      c.spring[touch.k[m]] = {{touch.held[0][m], touch.held[1][m], touch.held[2][m]}, touch.compliance[m], touch.loss[m]};
      c.held[touch.k[m]] = 1;
    }
  }
  touch.push_and_twist();
  add_up(touch, torque_sums, touch.twist_i, touch.twist_j);
}

void PairGranHysteretic::tally(const Touch &touch, Tally what)
{
  const int nlocal = atom->nlocal;
  for (int m = 0; m < touch.size; m++) {
    const double dx = touch.apart[0][m], dy = touch.apart[1][m], dz = touch.apart[2][m];
    const double fx = touch.push_i[0][m], fy = touch.push_i[1][m], fz = touch.push_i[2][m];
    if (what == Tally::PRESSURE) {
      const double share = touch.j[m] < nlocal ? 1.0 : 0.5;
      virial[0] += share * dx * fx;
      virial[1] += share * dy * fy;
      virial[2] += share * dz * fz;
      virial[3] += share * dx * fy;
      virial[4] += share * dx * fz;
      virial[5] += share * dy * fz;
      continue;
    }
    const Pairing &p = *touch.pairing[m];
    const double peak = contacts.peak[touch.k[m]], overlap = touch.overlap[m];
    double elastic = 0.4 * touch.force[m] * overlap;
    if (peak > p.scale.elastic_limit) {
      const Turning &turning = contacts.turnings[turning_of(touch.k[m], peak / p.scale.overlap, *p.law)];
      elastic = p.scale.force * p.scale.overlap * ContactLaw::elastic_energy(overlap / p.scale.overlap, turning);
    }
    ev_tally_xyz(touch.i[m], touch.j[m], nlocal, 0, elastic, 0.0, fx, fy, fz, dx, dy, dz);
  }
}

/* Into the sums of both spheres. The pairs of a row come one after the other. */

void PairGranHysteretic::add_up(const Touch &touch, granwave::TwofoldSums &sums, const double (&on_i)[3][Touch::MOST],
                                const double (&on_j)[3][Touch::MOST])
{
  const int nlocal = atom->nlocal;
  for (int m = 0; m < touch.size;) {
    const int i = touch.i[m];
    TwofoldSum sum = sums[i];
    for (; m < touch.size && touch.i[m] == i; m++) {
      sum.add(on_i[0][m], on_i[1][m], on_i[2][m]);
      if (touch.j[m] < nlocal) sums[touch.j[m]].add(on_j[0][m], on_j[1][m], on_j[2][m]);
    }
    sums[i] = sum;
  }
}

/* All that a batch of touching pairs does. */

void PairGranHysteretic::act(Touch &touch, Tally what)
{
  touch.measure();
  remember(touch);
  if (rubbing)
    rub(touch);
  else
    touch.push();
  add_up(touch, force_sums, touch.push_i, touch.push_j);
  if (what != Tally::NOTHING) tally(touch, what);
  touch.size = 0;
}

template <bool UNIFORM> void PairGranHysteretic::forces(Tally what)
{
  constexpr int ROWS_AT_A_TIME = 64;    // as few pairs touch in a packing at rest
  const double(*const x)[3] = reinterpret_cast<const double(*)[3]>(atom->x[0]);
  const double *const v = atom->v[0], *const omega = rubbing ? atom->omega[0] : nullptr;    // contiguous, as those below
  double *const f = atom->f[0], *const torque = rubbing ? atom->torque[0] : nullptr;
  const double *const radius = atom->radius;
  const int *const type = atom->type;
  const int nlocal = atom->nlocal;
  Contacts &c = contacts;
  const int rows = static_cast<int>(c.row.size());
  const int *const partner = c.partner.data();
  const double *const peak = c.peak.data();
  force_sums.reserve(c.ordered ? c.span + ROWS_AT_A_TIME : nlocal);
  if (rubbing) torque_sums.reserve(c.ordered ? c.span + ROWS_AT_A_TIME : nlocal);
  const auto give = [&](int i) {
    force_sums.give(i, f + 3 * i);
    if (rubbing) torque_sums.give(i, torque + 3 * i);
  };

  Touch touch;
  Pairing pairings[Touch::MOST];
  double touch_sq = 0.0, forget_sq = 0.0;
  if (UNIFORM) {
    pairings[0] = pairing(type[0], type[0], radius[0], radius[0]);
    touch_sq = pairings[0].touch_sq;
    forget_sq = (pairings[0].sum_radii + gap) * (pairings[0].sum_radii + gap);
  }

  int set = 0;      // places of the batch that know of their spheres, where all are alike
  int given = 0;    // rows whose spheres have their forces
  const auto act_up_to = [&](int row) {
    if (touch.size > 0) act(touch, what);
    for (; given < row; given++)
      if (c.ordered) give(c.row[given]);
  };
  for (int r = 0; r < rows; r++) {
    const int i = c.row[r], end = c.begin[r + 1];
    const double xi = x[i][0], yi = x[i][1], zi = x[i][2];
    const bool held = rubbing && any_held(c.begin[r], end);
    for (int k = c.begin[r]; k < end; k++) {
      const int j = partner[k];
      const double dx = xi - x[j][0], dy = yi - x[j][1], dz = zi - x[j][2];
      const double rsq = dx * dx + dy * dy + dz * dz;
      if (!UNIFORM) {
        const double sum = radius[i] + radius[j];
        touch_sq = touch_squared(sum);
        forget_sq = (sum + gap) * (sum + gap);
      }
      if (rsq >= touch_sq) {
        if (held && c.held[k]) let_go(k);
        if (rsq > forget_sq && peak[k] > 0.0) forget(r, k);
        continue;
      }
      const int m = touch.size++;
      touch.k[m] = k;
      touch.i[m] = i;
      touch.j[m] = j;
      touch.apart[0][m] = dx;
      touch.apart[1][m] = dy;
      touch.apart[2][m] = dz;
      touch.square[m] = rsq;
      if (rubbing) {    // what friction needs is on its way from memory while others are looked at
        __builtin_prefetch(&c.spring[k], 1);
        __builtin_prefetch(v + 3 * j);
        __builtin_prefetch(omega + 3 * j);
      }
      if (!UNIFORM) {
        pairings[m] = pairing(type[i], type[j], radius[i], radius[j]);
        touch.set(m, pairings[m]);
      } else if (m == set) {
        touch.set(set++, pairings[0]);
      }
      if (touch.size == Touch::MOST) act_up_to(r);
    }
    if (r + 1 - given >= ROWS_AT_A_TIME) act_up_to(r + 1);
  }
  act_up_to(rows);
  if (!c.ordered)
    for (int i = 0; i < nlocal; i++) give(i);
}

void PairGranHysteretic::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (update->ntimestep % STEPS_BETWEEN_CHECKS == 0) granwave::require_finite_motion(lmp);
  if (!contacts.valid) build_contacts();
  contacts.published = false;
  now = granwave::simulated_time(*update);
  // springs keep still where no time passes: a run that is set up anew goes on as if it had not been cut
  slips = update->whichflag == 1 && !update->setupflag;

  // LAMMPS asks for the pressure more often than anybody looks at it: it must cost next to nothing
  const Tally what = eflag_atom || vflag_atom || cvflag_atom || num_tally_compute > 0 ? Tally::EACH_PAIR
      : vflag_global                                                                  ? Tally::PRESSURE
                                                                                       : Tally::NOTHING;
  if (atom->nlocal > 0) uniform ? forces<true>(what) : forces<false>(what);
  if (eflag_global) eng_vdwl = tally_totals();
}

void PairGranHysteretic::overlap_error(int i, int j, double overlap)
{
  for (const int sphere : {i, j}) granwave::require_finite_motion(lmp, sphere);
  const bool face = atom->radius[i] == 0.0 || atom->radius[j] == 0.0;
  error->one(FLERR, fmt::format("Spheres {} and {} overlap by {:.3g}, more than {}: they were placed into each other, or the "
                                "timestep is far too large", atom->tag[i], atom->tag[j], overlap,
                                face ? "half the radius of the one that meets a flat face" : "the radius of the smaller one"));
}

