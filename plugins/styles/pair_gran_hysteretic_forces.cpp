// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: forces, with cohesion (cohesion.h), losses (viscous_loss.h), friction (tangential.h,
   partial_slip.h, tangential_damping.h), resistance to rolling and twisting (resistance.h). */

#include "pair_gran_hysteretic.h"

#include "comm.h"
#include "error.h"
#include "motion.h"
#include "neighbor.h"

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

constexpr int PEAKS_AHEAD = 256;    // pairs of the next batches, whose peaks are prefetched

}    // namespace

/* Velocity of approach of a touching pair; none in a minimization. */
double PairGranHysteretic::approach(const Batch &batch, int m) const
{
  if (update->whichflag != 1) return 0.0;
  const PairGeometry::Vector velocity = geometry.relative_velocity(batch.i[m], batch.j[m]);
  double sum = 0.0;
  for (int d = 0; d < 3; d++) sum -= batch.del[d][m] * velocity[d];
  return sum / batch.r[m];
}

/* Update the history of touching pairs, and the forces of those that have yielded. */
void PairGranHysteretic::update_history(Batch &batch)
{
  ContactList &c = contacts;
  if (has.n > has.size())
    for (int m = 0; m < batch.size; m++) {
      const int k = batch.k[m];
      const double velocity = has_rate && batch.overlap[m] > c.peak[k] ? approach(batch, m) : 0.0;
      if (batch.pair[m]->contact.update(batch.overlap[m], c.peak[k], velocity, c.block(k))) c.discard_turning(k);
    }
  for (int m = 0; m < batch.size; m++) {
    FETCH_AHEAD_TO_WRITE(c.peak.data() + batch.k[m] + PEAKS_AHEAD);
    batch.peak[m] = c.peak[batch.k[m]];
  }
  std::uint64_t raised, yielded;
  batch.compare_with_peaks(raised, yielded);
  for (std::uint64_t rest = raised; rest != 0; rest &= rest - 1) {
    const int m = lowest_bit(rest), k = batch.k[m];
    const double before = batch.peak[m];
    if (!has.dents && Front::crosses(before, batch.overlap[m])) c.front[k].rise(before, batch.overlap[m], now, step.dt);
    if ((before <= batch.elastic_limit[m] || has.dents) && batch.overlap[m] > batch.elastic_limit[m] &&
        c.time_yield[k] < 0.0)
      c.time_yield[k] = now;
    c.peak[k] = batch.overlap[m];
    c.time_peak[k] = now;
  }
  if (has.dents)
    for (int m = 0; m < batch.size; m++)
      if (batch.overlap[m] > c.reached[batch.k[m]]) c.raise_reached(batch.k[m], batch.overlap[m], now, step.dt);
  if (yielded != 0) compute_plastic(batch, yielded, raised);
}

/* Compute the forces and contact circles of those pairs of a batch that are beyond their elastic limit: on their loading curves
   if the peak has just been raised, or below their peaks. Bits as of compare_with_peaks(). */
void PairGranHysteretic::compute_plastic(Batch &batch, std::uint64_t beyond, std::uint64_t raised)
{
  ContactList &c = contacts;
  loading.size = unloading.size = 0;
  int yielded[Batch::CAPACITY], n_yielded = 0;
  for (; beyond != 0; beyond &= beyond - 1) yielded[n_yielded++] = lowest_bit(beyond);
  for (int n = 0; n < n_yielded; n++) FETCH_AHEAD(&c.turning[batch.k[yielded[n]]]);
  for (int n = 0; n < n_yielded; n++) {
    const int t = c.turning[batch.k[yielded[n]]];
    if (t >= 0) FETCH_AHEAD_TO_WRITE(&c.turnings[t]);
  }
  for (int n = 0; n < n_yielded; n++) {
    const int m = yielded[n], k = batch.k[m];
    const ScaledLaw &law = batch.pair[m]->contact;
    if (raised >> m & 1) {
      c.discard_turning(k);
      loading.site[loading.add(m, law, batch.overlap[m])] = law.site(c.block(k));
    } else {
      const int t = c.cached_turning(k, law);
      unloading.set(unloading.add(m, law, batch.overlap[m]), c.turnings[t], has.friction ? c.circle[t] : 0.0);
    }
  }
  if (loading.size > 0) loading.compute();
  if (unloading.size > 0) unloading.compute();
  for (const PlasticBatch *part : {static_cast<PlasticBatch *>(&loading), static_cast<PlasticBatch *>(&unloading)})
    for (int n = 0; n < part->size; n++) {
      batch.force[part->place[n]] = part->force[n];
      batch.circle[part->place[n]] = std::sqrt(part->circle[n]);
    }
}

/* ---------------------------------------------------------------------- cohesion */

/* Overwrite force and contact circle of pairs with cohesion, whose surfaces touch, are joined by a neck, or have just
   separated. */
void PairGranHysteretic::compute_cohesion(Batch &batch)
{
  ContactList &c = contacts;
  for (int m = 0; m < batch.size; m++) {
    const ScaledLaw &contact = batch.pair[m]->contact;
    if (!contact.cohesive()) continue;
    const int k = batch.k[m];
    const LawHistory h = c.law_history(k);
    const Turning *const turning = contact.yielded(h.peak) ? &c.turnings[c.cached_turning(k, contact)] : nullptr;
    const double rounding = TouchingPairs::ROUNDING * batch.radsum[m];
    const CohesiveState state = advance_cohesion(contact, *has.cohesion_of(c.block(k)), h, turning, batch.overlap[m],
                                                 rounding, approach(batch, m), step);
    batch.force[m] = state.force;
    batch.circle[m] = std::sqrt(state.circle_squared);
    batch.pressing[m] = state.pressing;
  }
}

/* ---------------------------------------------------------------------- viscous forces, and the end of contacts that have separated */

/* End the spring and the viscous force of a pair that has separated. */
void PairGranHysteretic::release_contact(int k)
{
  ContactList &c = contacts;
  if (has.loss && has.loss_of(c.block(k))->step > 0.0) {
    const int i = c.row[c.row_of(k)], j = c.partner[k];
    const PairParameters p = pair_parameters(i, j);
    part_viscous(p.loss, has, p.contact, c.block(k), p.radsum - geometry.distance(i, j), step, now);
  }
  if (has.friction) has.release_spring(c.spring[k], c.block(k));
  if (has.resistance) has.resistance_of(c.block(k))->release();
}

/* Effective mass of a pair along its normal. The body of a flat face is assumed to be much heavier than the sphere. */
double PairGranHysteretic::effective_mass(const Batch &batch, int m) const
{
  const int i = batch.i[m], j = batch.j[m];
  const double normal[3] = {batch.del[0][m] / batch.r[m], batch.del[1][m] / batch.r[m], batch.del[2][m] / batch.r[m]};
  return masses.effective(atom->radius[i] > 0.0 ? i : MovedMass::BODY, atom->radius[j] > 0.0 ? j : MovedMass::BODY, normal);
}

/* Slope of the force of the law against the overlap, for a touching pair without cohesion. */
double PairGranHysteretic::tangent_stiffness(const Batch &batch, int m)
{
  ContactList &c = contacts;
  const ScaledLaw &contact = batch.pair[m]->contact;
  const int k = batch.k[m];
  const double overlap = batch.overlap[m];
  if (!contact.yielded(c.peak[k]))
    return contact.is_hertzian() ? 1.5 * batch.force[m] / overlap : contact.elastic_stiffness(overlap);
  if (overlap >= c.peak[k]) return contact.tangent_stiffness(overlap, c.law_history(k));
  return contact.tangent_stiffness(overlap, c.turnings[c.cached_turning(k, contact)]);
}

/* Add the viscous forces of touching pairs to the normal forces; there are none in a minimization. */
void PairGranHysteretic::compute_viscous(Batch &batch)
{
  ContactList &c = contacts;
  for (int m = 0; m < batch.size; m++) {
    const PairParameters &p = *batch.pair[m];
    batch.damping[m] = -1.0;
    if (!p.loss) continue;
    const int k = batch.k[m];
    if (update->whichflag != 1) {
      has.forget_viscous(c.block(k));
      continue;
    }
    const PresentContact contact{p.contact,
                                 c.block(k),
                                 c.peak[k],
                                 batch.overlap[m],
                                 TouchingPairs::ROUNDING * p.radsum,
                                 approach(batch, m),
                                 batch.force[m],
                                 batch.pressing_force(m),
                                 batch.circle[m]};
    const ViscousForce viscous = advance_viscous(
        p.loss, has, contact, step, now, [&] { return tangent_stiffness(batch, m); },
        [&](double) { return effective_mass(batch, m); });
    batch.force[m] += viscous.normal;
    batch.damping[m] = viscous.damping;
  }
}

/* ---------------------------------------------------------------------- friction, rolling and twisting */

/* Advance the tangential springs of touching pairs and compute the forces on the spheres, including friction. */
void PairGranHysteretic::compute_tangential(Batch &batch, bool special)
{
  ContactList &c = contacts;
  bool without = batch.prepare_friction();
  if (has.cohesion)
    for (int m = 0; m < batch.size; m++) {
      if (!batch.pair[m]->contact.cohesive()) continue;
      batch.limit[m] = batch.friction[m] * batch.pressing[m];
      without = without || !(batch.limit[m] > 0.0);
    }
  if (without)
    for (int m = 0; m < batch.size; m++) {
      if (batch.limit[m] > 0.0) continue;
      has.release_spring(c.spring[batch.k[m]], c.block(batch.k[m]));
      batch.circle[m] = 1.0;    // any value, for a pair without friction
    }
  batch.read(components(atom->v), components(atom->omega), c.spring.data());
  if (special && geometry.flows()) set_relative_velocities(batch);
  if (step.advances) batch.advance_forces_and_torques(step.dt);
  else batch.compute_forces_and_torques();
  bool changed = (has.slip || has.damping) && advance_friction(batch);
  if (step.advances) batch.write(c.spring.data());
  if (has.damping && add_damping(batch)) changed = true;
  if (changed) batch.compute_forces_and_torques();
}

/* Replace the tangential forces of the pairs with partial slip by those of their rows of springs, and of the pairs with damping along
   the surface by those of springs that slide earlier or later. Returns true if there are any. */
bool PairGranHysteretic::advance_friction(Batch &batch)
{
  bool any = false;
  for (int m = 0; m < batch.size; m++) {
    const PairParameters &p = *batch.pair[m];
    const bool damps = p.loss.tangential > 0.0;
    const bool slips = step.advances && p.tangential_model == TangentialModel::PARTIAL_SLIP;
    if (!(damps || slips) || !(batch.limit[m] > 0.0)) continue;
    any = true;
    double normal[3], velocity[3], spin[3];
    for (int d = 0; d < 3; d++) {
      normal[d] = batch.normal[d][m];
      velocity[d] = batch.velocity[d][m];
      spin[d] = batch.spin[d][m];
    }
    const SlipContact contact = slip_contact(p.contact, batch.circle[m], batch.limit[m], normal, velocity, spin, step.dt);
    const int k = batch.k[m];
    TangentialSpring spring = contacts.spring[k];
    step_friction(has, spring, contacts.block(k), contact, p.tangential_model, damps ? &batch.damping[m] : nullptr, step);
    for (int d = 0; d < 3; d++) batch.tangential[d][m] = spring.force[d];
    batch.compliance[m] = spring.compliance;
    batch.loss[m] = spring.loss;
  }
  return any;
}

/* Add the damping along the surface to the tangential forces. Returns true if there is any. */
bool PairGranHysteretic::add_damping(Batch &batch)
{
  bool any = false;
  for (int m = 0; m < batch.size; m++) {
    if (!(batch.pair[m]->loss.tangential > 0.0 && batch.limit[m] > 0.0)) continue;
    any = true;
    const DampingHistory history = has.damping_of(contacts.block(batch.k[m]));
    for (int d = 0; d < 3; d++) batch.tangential[d][m] += history.force()[d];
  }
  return any;
}

/* Advance the resistances of touching pairs to rolling and twisting, and compute their torques. */
void PairGranHysteretic::compute_resistance(const Batch &batch, const double *circle, double (*moment)[3])
{
  const double *const *const omega = atom->omega;
  for (int m = 0; m < batch.size; m++) {
    std::fill_n(moment[m], 3, 0.0);
    const PairParameters &p = *batch.pair[m];
    if (!p.resistance) continue;
    RollingContact contact{
        {}, {}, p.contact.effective_radius(), batch.pressing_force(m), circle[m], p.shear_stiffness * circle[m], p.friction};
    for (int d = 0; d < 3; d++) {
      contact.normal[d] = batch.normal[d][m];
      contact.spin[d] = omega[batch.i[m]][d] - omega[batch.j[m]][d];
    }
    step_resistance(*p.resistance, *has.resistance_of(contacts.block(batch.k[m])), contact, step, moment[m]);
  }
}

/* ---------------------------------------------------------------------- all forces of a batch, and of all contacts */

void PairGranHysteretic::tally(const Batch &batch, Tally what)
{
  const int nlocal = atom->nlocal;
  for (int m = 0; m < batch.size; m++) {
    const double delx = batch.del[0][m], dely = batch.del[1][m], delz = batch.del[2][m];
    double f[3];
    for (int d = 0; d < 3; d++) f[d] = has.friction ? batch.force_i[d][m] : batch.del[d][m] * batch.pair_force[m];
    const double fx = f[0], fy = f[1], fz = f[2];
    if (what == Tally::VIRIAL) {
      const double share = batch.i[m] < nlocal && batch.j[m] < nlocal ? 1.0 : 0.5;
      virial[0] += share * delx * fx;
      virial[1] += share * dely * fy;
      virial[2] += share * delz * fz;
      virial[3] += share * delx * fy;
      virial[4] += share * delx * fz;
      virial[5] += share * dely * fz;
      continue;
    }
    const int k = batch.k[m];
    const ScaledLaw &contact = batch.pair[m]->contact;
    const Turning *const turning =
        contact.yielded(contacts.peak[k]) ? &contacts.turnings[contacts.cached_turning(k, contact)] : nullptr;
    const double stored = has.stored_energy(contact, batch.overlap[m], contacts.law_history(k), turning);
    ev_tally_xyz(batch.i[m], batch.j[m], nlocal, 0, stored, 0.0, fx, fy, fz, delx, dely, delz);
  }
}

/* Compute forces and history of a batch of touching pairs. */
void PairGranHysteretic::compute_batch(Tally what, bool special)
{
  if (!uniform)
    for (int m = 0; m < batch.size; m++) {
      const int i = batch.i[m], j = batch.j[m], itype = atom->type[i], jtype = atom->type[j];
      if (laws.has_table()) {
        batch.set(m, laws.from_table(itype, jtype));
      } else {
        batch.parameters[m] = laws.parameters(itype, jtype, atom->radius[i], atom->radius[j]);
        batch.set(m, batch.parameters[m]);
      }
    }
  if (batch.compute_overlap())
    for (int m = 0; m < batch.size; m++)
      if (!(batch.overlap[m] <= batch.largest_overlap[m])) overlap_error(batch.i[m], batch.j[m], batch.overlap[m]);
  if (special) set_elastic(batch);
  update_history(batch);
  if (special && has.cohesion) compute_cohesion(batch);
  if (has.loss) compute_viscous(batch);
  if (has.resistance) {
    double circle[Batch::CAPACITY], moment[Batch::CAPACITY][3];
    std::copy_n(batch.circle, batch.size, circle);
    compute_tangential(batch, special);
    compute_resistance(batch, circle, moment);
    batch.add_forces_and_moments(components(atom->f), components(atom->torque), atom->nlocal, moment);
  } else if (has.friction) {
    compute_tangential(batch, special);
    batch.add_forces_and_torques(components(atom->f), components(atom->torque), atom->nlocal, contacts.spring.data());
  } else {
    batch.compute_normal();
    batch.add_normal(components(atom->f), atom->nlocal);
  }
  if (what != Tally::NONE) tally(batch, what);
}

void PairGranHysteretic::forget_far_pairs(int r)
{
  const int i = contacts.row[r];
  for (int k = contacts.begin[r]; k < contacts.begin[r + 1]; k++) {
    if (contacts.peak[k] == 0.0) continue;
    const int j = contacts.partner[k];
    const double reach = atom->radius[i] + atom->radius[j] + gap;
    if (geometry.distance_squared(i, j) > reach * reach) forget(r, k);
  }
}

void PairGranHysteretic::compute_forces(Tally what)
{
  ContactList &c = contacts;
  const int nall = atom->nlocal + atom->nghost, rows = c.plain;
  if (c.resting.compare(atom->x[0], nall, atom->radius, uniform ? 1 : nall)) {
    if (radii_vary) require_largest_radii();
    set_parameters();
  }
  pairs.x = c.resting.coordinates(0);
  pairs.y = c.resting.coordinates(1);
  pairs.z = c.resting.coordinates(2);
  pairs.radius = uniform ? nullptr : c.resting.radii();
  pairs.uniform_radius = atom->radius[0];
  pairs.gap = gap;

  batch.size = 0;
  for (int begin = 0; begin < rows; begin += RestingBlocks::SIZE) {
    const int block = RestingBlocks::of(begin);
    if (c.resting.rests(block)) continue;
    bool quiet = true;
    pairs.start(c.groups.begin(block), c.groups.end(block),
                has.friction || has.loss ? c.touched.data() + c.groups.first(block) : nullptr);
    for (bool done = false; !done;) {
      const int before = batch.size;
      done = pairs.collect(batch);
      for (const int k : pairs.parted) release_contact(k);
      for (const int k : pairs.far)
        if (c.peak[k] != 0.0) forget(c.row_of(k), k);
      quiet = quiet && batch.size == before;
      if (batch.size < Batch::CAPACITY) continue;
      compute_batch(what);
      batch.size = 0;
    }
    c.resting.set_quiet(block, quiet);
  }
  if (batch.size > 0) compute_batch(what);
  compute_special(what);
}

/* In a minimization, begin with its initial histories: only the final positions leave dents. */
void PairGranHysteretic::begin_evaluation()
{
  if (update->whichflag != 2) contacts.start.kept = false;
  else if (contacts.start.kept) contacts.return_to_start();
  else contacts.keep_start();
}

void PairGranHysteretic::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (evaluations++ % STEPS_BETWEEN_CHECKS == 0) require_finite_motion(lmp);
  if (is_rerun(*update) && (has.friction || fix_history->history.layout().n_extra > 0))
    error->all(
        FLERR,
        "Pair style gran/hysteretic: rerun lacks the steps between its snapshots, by which the history of contacts with "
        "more than a dent grows");
  if (neighbor->ago == 0) renew_ghosts();
  if (!contacts.valid) build_contacts();
  geometry.begin_evaluation();
  if (sends_velocities) {
    if (neighbor->ago == 0) ghosts.renew();
    send(Message::VELOCITIES);
  }
  if (has_dashpot && masses.differ() && neighbor->ago == 0 && update->whichflag == 1) {
    masses.update();
    send(Message::MASSES);
  }
  begin_evaluation();
  contacts.published = false;
  now = simulated_time(*update);
  step = {update->dt, update->whichflag == 1 && !update->setupflag};

  // LAMMPS requests the pressure more often than it is used: its cost must be negligible
  const Tally what = eflag_atom || vflag_atom || cvflag_atom || num_tally_compute > 0 ? Tally::EACH_PAIR
                     : vflag_global                                                   ? Tally::VIRIAL
                                                                                      : Tally::NONE;
  if (atom->nlocal > 0) compute_forces(what);
  if (eflag_global) eng_vdwl = tally_totals();
}

void PairGranHysteretic::overlap_error(int i, int j, double overlap)
{
  for (const int sphere : {i, j}) require_finite_motion(lmp, sphere);
  const bool face = atom->radius[i] == 0.0 || atom->radius[j] == 0.0;
  const double speed = std::max(speed_of(lmp, i), speed_of(lmp, j));
  const double radius = PairLaws::largest_overlap(atom->radius[i], atom->radius[j]);
  error->one(FLERR, "Spheres {} and {} overlap by {:.3g}, more than {}: {}", atom->tag[i], atom->tag[j], overlap,
             face ? "half the radius of the sphere that touches a flat face" : "the radius of the smaller sphere",
             causes_of_overlap(lmp, speed, radius, "their initial positions overlap"));
}
