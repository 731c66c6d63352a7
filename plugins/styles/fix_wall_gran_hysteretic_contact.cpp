// SPDX-License-Identifier: GPL-2.0-only
/* Fix wall/gran/hysteretic: normal, viscous and tangential force of one contact, and the history that they change; energies and counts
   of all spheres, and the values of the global scalar and vector. */

#include "fix_wall_gran_hysteretic.h"

#include "domain.h"
#include "error.h"
#include "motion.h"

using namespace LAMMPS_NS;
using namespace granwave;

/* Squared distance between two locations on the wall, to the nearest image. */
double FixWallGranHysteretic::distance_squared(const double from[3], const double to[3]) const
{
  double distance[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  const auto wrap = [&](int d, double period, double other) {
    const double turns = period > 0.0 ? std::round(distance[d] / period) : 0.0;
    distance[d] -= period * turns;
    distance[1 - d] -= other * turns;
  };
  if (curved && curved->is_in_space())
    return distance[0] * distance[0] + distance[1] * distance[1] + distance[2] * distance[2];
  if (curved) {
    wrap(0, curved->circumference(), 0.0);
    wrap(1, domain->periodicity[2] ? domain->prd[2] : 0.0, 0.0);
  } else {
    const int along[2] = {(axis + 1) % 3, (axis + 2) % 3};
    const bool first_is_last =
        along[0] > along[1];    // across the later one of x, y, z a tilted box is shifted along the other
    const double tilt = !domain->triclinic ? 0.0 : axis == 0 ? domain->yz : axis == 1 ? domain->xz : domain->xy;
    for (const int d : {first_is_last ? 0 : 1, first_is_last ? 1 : 0})
      wrap(d, domain->periodicity[along[d]] ? domain->prd[along[d]] : 0.0, along[d] > along[1 - d] ? tilt : 0.0);
  }
  return distance[0] * distance[0] + distance[1] * distance[1];
}

/* Energy dissipated by yielding at one wall in this run. */
double FixWallGranHysteretic::lost(int i, int which, const ScaledLaw &scaled)
{
  const Side &side = histories.side(i, which);
  return side.lost_before + scaled.dissipated_energy(law_history(i, which)) -
         scaled.dissipated_energy({side.initial, initial_extra(i, which)});
}

/* Velocity of approach of sphere i to one wall; none in a minimization. */
double FixWallGranHysteretic::approach(int i, int which) const
{
  if (update->whichflag != 1) return 0.0;
  double normal[3], sum = 0.0;
  inward(i, which, normal);
  for (int d = 0; d < 3; d++) sum -= normal[d] * atom->v[i][d];
  return support && which == moving ? sum - support->velocity() : sum;
}

/* Compute the normal force of one wall on sphere i, which overlaps with it, and update its dent and its output. If the contact
   is along a line, its force is in line_force at the index `line`. */
FixWallGranHysteretic::Contact FixWallGranHysteretic::compute_normal(int i, int which, double overlap, double now,
                                                                     std::size_t line)
{
  double *const state = array_atom[i];
  Side &side = histories.side(i, which);
  const double radius = atom->radius[i];
  if (!(overlap <= radius)) {
    require_finite_motion(lmp, i);
    error->one(FLERR, "Sphere {} reaches {:.3g} into the wall of fix {}, more than its radius {:.3g}: {}", atom->tag[i],
               overlap, id, radius,
               causes_of_overlap(lmp, speed_of(lmp, i), radius, "its initial position overlaps with the wall"));
  }
  if (curved && !curved->holds(radius))
    error->one(FLERR, "Fix {} {}: sphere {} of radius {:.6g} does not fit into the {}", STYLE, id, atom->tag[i], radius,
               curved->name());
  const ScaledLaw &scaled = scaled_law(i);
  const double effective = scaled.effective_radius();
  if (!(overlap < scaled.largest_overlap()))
    error->one(
        FLERR,
        "Cylinder {} reaches {:.3g} into the wall of fix {}, beyond the range of the law of a line contact: it is too short",
        atom->tag[i], overlap, id);
  if (side.touching == 0.0) {
    side.touching = 1.0;
    if (side.dent > 0.0) {
      const double circle_sq =
          std::isfinite(scaled.yield_overlap()) ? scaled.loading_circle(side.dent, extra(i, which)) : effective * side.dent;
      double place[3];
      place_of(i, place);
      if (distance_squared(side.place, place) > circle_sq) {
        side.lost_before = lost(i, which, scaled);
        side.dent = side.initial = 0.0;
        std::fill_n(extra(i, which), law.n_extra(), 0.0);
        if (has.prony) *has.prony_of(extra(i, which)) = {};
      }
    }
  }
  if (law.n_extra() > 0) scaled.update(overlap, side.dent, approach(i, which), extra(i, which));
  const bool raised = overlap > side.dent;
  if (raised) {
    side.dent = overlap;
    place_of(i, side.place);
  }
  Contact contact{};
  contact.damping = -1.0;
  double circle_squared = 0.0;
  if (scaled.line()) {
    contact.force = line_force[line];
    if (support) contact.stiffness = line_stiffness[line];
    if (has.friction) circle_squared = scaled.circle_squared(line_stiffness[line]);
  } else if (!scaled.yielded(side.dent)) {
    contact.force = scaled.elastic_force(overlap);
    if (support)
      contact.stiffness = scaled.is_hertzian() ? 1.5 * contact.force / overlap : scaled.elastic_stiffness(overlap);
    if (has.friction)
      circle_squared = scaled.is_hertzian() ? effective * overlap : scaled.circle_squared(overlap, law_history(i, which));
  } else {
    const Turning turning = scaled.turning(law_history(i, which));
    contact.force = raised ? scaled.peak_force(turning) : scaled.unloading(overlap, turning);
    if (support) contact.stiffness = scaled.stiffness(turning);
    if (has.friction)
      circle_squared = raised ? scaled.loading_circle(overlap, extra(i, which))
                              : scaled.unloading_circle(overlap, turning, scaled.area(turning.peak, extra(i, which)));
    if (raised) {
      if (state[TIME_YIELD] < 0.0) state[TIME_YIELD] = now;
      state[DISSIPATED] = lost(i, 0, scaled) + lost(i, 1, scaled);
    }
  }
  contact.circle = std::sqrt(circle_squared);
  if (has.cohesion) compute_cohesion(i, which, overlap, scaled, contact);
  if (loss) compute_viscous(i, which, overlap, scaled, contact);
  if (!has.cohesion) contact.pressing = contact.force;
  if (contact.force > state[FORCE] || state[FORCE] == 0.0) {
    state[FORCE] = contact.force;
    state[OVERLAP] = overlap;
  }
  if (contact.force > state[PEAK_FORCE]) note_largest_force(i, contact.force, now);
  state[PEAK_OVERLAP] = std::max(state[PEAK_OVERLAP], overlap);
  touched[i] = 1;
  return contact;
}

/* Record the largest force of sphere i on the walls so far, and the time of arrival of the wave. */
void FixWallGranHysteretic::note_largest_force(int i, double force, double now)
{
  double *const state = array_atom[i];
  Front &front = fronts[i];
  if (Front::crosses(state[PEAK_FORCE], force)) front.rise(state[PEAK_FORCE], force, now, update->dt);
  state[PEAK_FORCE] = force;
  state[TIME_PEAK] = now;
  state[TIME_FIRST] = front.passed(force, ARRIVED);
}

/* Return true if sphere i touches one wall, is joined to it by a neck, or has just separated. */
bool FixWallGranHysteretic::joins(int i, int which, double overlap)
{
  return !(overlap <= ROUNDING * atom->radius[i]) || (has.cohesion && sticking(i, which)->active());    // also true for NaN
}

/* Overwrite force and contact circle of a contact with cohesion, as the pair style does. */
void FixWallGranHysteretic::compute_cohesion(int i, int which, double overlap, const ScaledLaw &scaled, Contact &contact)
{
  const LawHistory h = law_history(i, which);
  const bool yielded = scaled.yielded(h.peak);
  const Turning turning = yielded ? scaled.turning(h) : Turning{};
  const CohesiveState state = advance_cohesion(scaled, *sticking(i, which), h, yielded ? &turning : nullptr, overlap,
                                               ROUNDING * atom->radius[i], approach(i, which), step());
  contact.force = state.force;
  contact.circle = std::sqrt(state.circle_squared);
  contact.pressing = state.pressing;
  if (support) contact.stiffness = std::max(overlap > 0.0 ? contact.stiffness : 0.0, 2.0 * law.modulus() * contact.circle);
}

/* Effective mass of sphere i and one wall, from the tangent stiffness of their contact. */
double FixWallGranHysteretic::effective_mass(int i, int which, double stiffness) const
{
  double normal[3];
  inward(i, which, normal);
  const bool moves = support && which == moving;
  return masses.effective(i, MovedMass::BODY, normal, moves ? 1.0 / support->moved_mass(atom->rmass[i], stiffness) : 0.0);
}

/* Add the viscous force of one wall on sphere i to the normal force; there is none in a minimization. */
void FixWallGranHysteretic::compute_viscous(int i, int which, double overlap, const ScaledLaw &scaled, Contact &contact)
{
  if (update->whichflag != 1) return has.forget_viscous(extra(i, which));
  const LawHistory h = law_history(i, which);
  const PresentContact present{
      scaled,        extra(i, which),  h.peak,        overlap, ROUNDING * atom->radius[i], approach(i, which),
      contact.force, contact.pressing, contact.circle};
  const ViscousForce viscous = advance_viscous(
      loss, has, present, step(), simulated_time(*update), [&] { return scaled.tangent_stiffness(overlap, h); },
      [&](double stiffness) { return effective_mass(i, which, stiffness); });
  contact.force += viscous.normal;
  contact.damping = viscous.damping;
}

/* Advance spring and damping of one wall at sphere i, with this lever arm. */
void FixWallGranHysteretic::advance_friction(int i, int which, double lever, const Contact &contact)
{
  const double *const v = atom->v[i], *const omega = atom->omega[i];
  const double velocity[3] = {v[0], v[1], v[2]}, spin[3] = {lever * omega[0], lever * omega[1], lever * omega[2]};
  double normal[3];
  inward(i, which, normal);
  const SlipContact slipping =
      slip_contact(scaled_law(i), contact.circle, friction * contact.pressing, normal, velocity, spin, update->dt);
  step_friction(has, histories.spring(i, which), extra(i, which), slipping, tangential_model,
                has.damping ? &contact.damping : nullptr, step());
}

/* Tangential force of one wall on sphere i, by the spring and by damping. */
void FixWallGranHysteretic::friction_force(int i, int which, double force[3])
{
  std::copy_n(histories.spring(i, which).force, 3, force);
  if (!has.damping) return;
  const DampingHistory history = has.damping_of(extra(i, which));
  for (int d = 0; d < 3; d++) force[d] += history.force()[d];
}

/* Compute the tangential force of one wall on sphere i, and its torque. */
void FixWallGranHysteretic::compute_tangential(int i, int which, double overlap, const Contact &contact)
{
  double *const state = array_atom[i];
  if (!(contact.pressing > 0.0)) {
    has.release_spring(histories.spring(i, which), extra(i, which));
    return;
  }
  const double lever = atom->radius[i] - (cylinders && is_line(i) ? 1.0 : 0.5) * overlap;
  advance_friction(i, which, lever, contact);
  double normal[3], force[3], torque[3];
  inward(i, which, normal);
  friction_force(i, which, force);
  torque_per_lever(normal, force, torque);
  for (int d = 0; d < 3; d++) {
    atom->f[i][d] += force[d];
    atom->torque[i][d] += lever * torque[d];
  }
  // on the wall: along x, y, z, or outward, around and along a tube, or outward
  double on_wall[3] = {-force[0], -force[1], -force[2]};
  if (curved) curved->components(atom->x[i], on_wall);
  for (int d = 0; d < 3; d++) wall_force[d] += on_wall[d];
  if (contact.force == state[FORCE]) state[TANGENTIAL] = std::sqrt(dot(force, force));
}

/* Compute the torque by which one wall resists rolling and twisting of sphere i. */
void FixWallGranHysteretic::compute_resistance(int i, int which, const Contact &contact)
{
  const double *const omega = atom->omega[i];
  RollingContact rolling{{},
                         {omega[0], omega[1], omega[2]},
                         scaled_law(i).effective_radius(),
                         contact.pressing,
                         contact.circle,
                         law.tangential_stiffness(contact.circle),
                         friction};
  inward(i, which, rolling.normal);
  double torque[3];
  step_resistance(resistance, *resisted(i, which), rolling, step(), torque);
  for (int d = 0; d < 3; d++) atom->torque[i][d] += torque[d];
}

/* Update the columns of the energies dissipated by viscous forces, sliding, rolling and twisting at both walls. */
void FixWallGranHysteretic::report_losses(int i)
{
  double *const state = array_atom[i];
  if (loss) state[VISCOUS] = viscous_loss(i, 0) + viscous_loss(i, 1);
  if (!has.friction) return;
  state[FRICTION_LOSS] = friction > 0.0 ? histories.spring(i, 0).loss + histories.spring(i, 1).loss : 0.0;
  if (resistance) state[FRICTION_LOSS] += resisted(i, 0)->loss() + resisted(i, 1)->loss();
}

/* End the contacts of a sphere that no longer touches the walls. Its losses stay in the totals. */
void FixWallGranHysteretic::part(int i)
{
  near[i] = 0;
  array_atom[i][OVERLAP] = array_atom[i][FORCE] = array_atom[i][TANGENTIAL] = 0.0;
  for (int side = 0; side < 2; side++) {
    histories.side(i, side).touching = 0.0;
    if (loss) has.forget_viscous(extra(i, side));
    if (friction > 0.0) has.release_spring(histories.spring(i, side), extra(i, side));
    if (resistance) resisted(i, side)->release();
    if (has.cohesion) sticking(i, side)->forget_state();
  }
  report_losses(i);
}

/* ---------------------------------------------------------------------- output */

void FixWallGranHysteretic::tally()
{
  if (tallied == update->ntimestep) return;
  tallied = update->ntimestep;
  double mine[N_TOTALS] = {};
  for (int i = 0; i < atom->nlocal; i++) {
    if (!touched[i]) continue;
    const double *state = array_atom[i];
    touched[i] = state[PEAK_OVERLAP] > 0.0;
    if (!touched[i]) continue;
    const ScaledLaw &scaled = scaled_law(i);
    mine[DISSIPATED_SUM] += state[DISSIPATED];
    mine[FRICTION_LOSS_SUM] += state[FRICTION_LOSS];
    mine[VISCOUS_SUM] += state[VISCOUS];
    if (law.entry().yields() && state[TIME_YIELD] >= 0.0) mine[YIELDED] += 1.0;
    if (state[PEAK_OVERLAP] > scaled.valid_overlap()) mine[BEYOND_LAW] += 1.0;
    for (int side = 0; side < 2; side++) {
      const Side &own = histories.side(i, side);
      const double overlap = depth(i, side);
      if (friction > 0.0) mine[TANGENTIAL_STORED] += has.tangential_energy(histories.spring(i, side), extra(i, side));
      if (resistance) {
        const ResistanceHistory history = *resisted(i, side);
        mine[ROLLING] += history.rolling.stored();
        mine[ROLLED] += history.rolling.loss;
        mine[TWISTING] += history.twisting.stored();
        mine[TWISTED] += history.twisting.loss;
        mine[FRICTION_LOSS_SUM] -= history.loss();    // that of sliding remains
      }
      if (has.cohesion) {
        const CohesionHistory history = *sticking(i, side);
        mine[ADHESIVE] += history.lost;
      }
      if (own.touching != 0.0 || has.cohesion) mine[STORED] += has.stored_energy(scaled, overlap, law_history(i, side));
    }
  }
  MPI_Allreduce(mine, totals, N_TOTALS, MPI_DOUBLE, MPI_SUM, world);
}

void FixWallGranHysteretic::add_magnitudes(int i, double sums[3])
{
  const double force = array_atom[i][FORCE];
  if (force == 0.0) return;
  double normal[3];
  inward(i, 1, normal);
  for (int d = 0; d < 3; d++) {
    double along = 0.0;
    for (int side = 0; side < 2 && friction > 0.0; side++) {
      double tangential[3];
      friction_force(i, side, tangential);
      along += tangential[d];
    }
    sums[d] += std::fabs(force * normal[d]) + std::fabs(along);
  }
}

double FixWallGranHysteretic::compute_scalar()
{
  tally();
  return totals[STORED];
}

double FixWallGranHysteretic::compute_vector(int n)
{
  if (n < 3) {
    double sum = 0.0;
    MPI_Allreduce(&wall_force[n], &sum, 1, MPI_DOUBLE, MPI_SUM, world);
    return sum;
  }
  constexpr int AT_SUPPORT = 3 + VISCOUS_SUM, N_SUPPORT = 6;    // first value of the support; further totals come after it
  if (n < AT_SUPPORT || n >= AT_SUPPORT + N_SUPPORT) {
    tally();
    return totals[n < AT_SUPPORT ? n - 3 : n - 3 - N_SUPPORT];
  }
  if (!support) return 0.0;
  const double of_support[] = {support->displacement(), support->velocity(),        support->energy(),
                               support->damped(),       support->force_on_ground(), support->work()};
  return of_support[n - AT_SUPPORT];
}
