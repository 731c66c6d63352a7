// SPDX-License-Identifier: GPL-2.0-only
/* Fix wall/gran/hysteretic: forces and motion of the plane. Per-sphere state, initial dents and restart files are in
   fix_wall_gran_hysteretic_state.cpp, totals in fix_wall_gran_hysteretic_totals.cpp. */

#include "fix_wall_gran_hysteretic.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "finite_motion.h"
#include "fix_gran_cylinder.h"
#include "../laws/law_arguments.h"
#include "neighbor.h"
#include "simulated_time.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

using namespace LAMMPS_NS;
using granwave::INFINITE;
using granwave::ScaledLaw;
using granwave::TangentialSpring;

namespace {

constexpr double ROUNDING = 1e-12;    // relative to the radius: smaller overlaps are rounding errors of positions

}    // namespace

FixWallGranHysteretic::FixWallGranHysteretic(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg < 7)
    error->all(FLERR, "Illegal fix {}: expected xplane|yplane|zplane LO HI or tube RADIUS, a law and its constants", STYLE);
  std::fill_n(plane, 2, INFINITE);
  plane[0] = -INFINITE;
  int used_words = 6;
  if (std::strcmp(arg[3], "tube") == 0) {
    used_words = 5;
    const double radius = utils::numeric(FLERR, arg[4], false, lmp);
    if (!(radius > 0.0 && std::isfinite(radius)))
      error->all(FLERR, "Illegal fix {}: the radius of the tube must be above 0, found {}", STYLE, arg[4]);
    tube = std::make_unique<granwave::Tube>(radius);
  } else {
    axis = arg[3][0] - 'x';
    if (axis < 0 || axis > 2 || std::strcmp(arg[3] + 1, "plane") != 0)
      error->all(FLERR, "Illegal fix {}: expected xplane, yplane, zplane or tube, found {}", STYLE, arg[3]);
    for (int side = 0; side < 2; side++)
      if (std::strcmp(arg[4 + side], "NULL") != 0) plane[side] = utils::numeric(FLERR, arg[4 + side], false, lmp);
    if (!(plane[0] < plane[1])) error->all(FLERR, "Illegal fix {}: LO must be below HI, found {} {}", STYLE, arg[4], arg[5]);
  }
  std::vector<std::string> words(arg + used_words, arg + narg);
  try {
    if (const auto at = std::find(words.begin(), words.end(), "support"); at != words.end()) {
      std::size_t used = 0;
      support = std::make_unique<granwave::Support>(std::vector<std::string>(at + 1, words.end()), used);
      words.erase(at, at + 1 + used);
      if (tube) throw std::invalid_argument("support moves a plane, found a tube");
      if (std::isfinite(plane[0]) && std::isfinite(plane[1]))
        throw std::invalid_argument("support moves one plane, found two: take a fix for each");
      if (!std::isfinite(plane[0]) && !std::isfinite(plane[1]))
        throw std::invalid_argument("support moves a plane, found none");
      moving = std::isfinite(plane[0]) ? 0 : 1;
    }
    if (const auto at = std::find(words.begin(), words.end(), "line"); at != words.end()) {
      const std::string kind = at + 1 == words.end() ? "" : at[1];
      if (kind != "half-space" && kind != "plane-strain")
        throw std::invalid_argument("line must be half-space or plane-strain, found '" + kind + "'");
      plane_strain = kind == "plane-strain";
      words.erase(at, at + 2);
    }
    const granwave::LawArguments args = granwave::parse_law(words);
    body = args.first;
    wall = args.second.value_or(granwave::Material{INFINITE, 0.0, INFINITE});
    law = args.contact(body, wall);
    friction = args.friction;
    tangential_model = args.tangential;
    loss = args.loss;
  } catch (const std::invalid_argument &fault) {
    error->all(FLERR, "Illegal fix {}: {}", STYLE, fault.what());
  }

  restart_peratom = 1;
  restart_global = support ? 1 : 0;
  create_attribute = 1;
  scalar_flag = vector_flag = 1;
  size_vector = std::size(extensive);
  global_freq = 1;
  extscalar = 1;
  extvector = -1;
  extlist = extensive;
  peratom_flag = 1;
  size_peratom_cols = N_REPORTED;
  peratom_freq = 1;
  maxexchange = n_state();
  std::fill_n(wall_force, 3, 0.0);
  std::fill_n(totals, static_cast<int>(N_TOTALS), 0.0);

  FixWallGranHysteretic::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
  for (int i = 0; i < atom->nlocal; i++) FixWallGranHysteretic::set_arrays(i);
}

int FixWallGranHysteretic::setmask()
{
  const int forces = FixConst::POST_FORCE | FixConst::MIN_POST_FORCE | FixConst::POST_NEIGHBOR | FixConst::MIN_POST_NEIGHBOR;
  return support ? forces | FixConst::INITIAL_INTEGRATE | FixConst::FINAL_INTEGRATE : forces;
}

void FixWallGranHysteretic::init()
{
  if (std::strncmp(update->integrate_style, "respa", 5) == 0)
    error->all(FLERR, "Fix {} does not work with run_style respa", STYLE);
  if (!atom->radius_flag) error->all(FLERR, "Fix {} requires atom attribute radius (atom_style sphere)", STYLE);
  if (loss && !atom->rmass_flag)
    error->all(FLERR, "Fix {} with a loss requires atom attribute rmass (atom_style sphere)", STYLE);
  if (friction > 0.0 && !(atom->omega_flag && atom->torque_flag))
    error->all(FLERR, "Fix {} with friction requires atom attributes omega and torque (atom_style sphere)", STYLE);
  if (tube ? domain->periodicity[0] || domain->periodicity[1] : domain->periodicity[axis])
    error->all(FLERR, "Fix {}: the box is periodic across the wall", STYLE);
  init_cylinders();
  reset_dt();
}

void FixWallGranHysteretic::reset_dt()
{
  if (update->whichflag == 1) check_timestep(0.0);
}

/* ---------------------------------------------------------------------- motion of the plane */

void FixWallGranHysteretic::setup(int)
{
  listed = false;
  evaluate();
}

void FixWallGranHysteretic::min_setup(int)
{
  listed = false;
  evaluate();
}

void FixWallGranHysteretic::post_neighbor() { listed = false; }
void FixWallGranHysteretic::min_post_neighbor() { listed = false; }

void FixWallGranHysteretic::initial_integrate(int) { support->advance(update->dt); }
void FixWallGranHysteretic::post_force(int) { evaluate(); }
void FixWallGranHysteretic::final_integrate() { support->finish(update->dt); }

void FixWallGranHysteretic::min_post_force(int)
{
  if (support) support->settle(contact_stiffness);
  evaluate();
}

/* fix_modify ID velocity V: of a free plate, towards the spheres. */

int FixWallGranHysteretic::modify_param(int narg, char **arg)
{
  if (std::strcmp(arg[0], "velocity") != 0) return 0;
  if (narg < 2) error->all(FLERR, "Illegal fix_modify {}: expected velocity V", id);
  if (!support || !support->launch(utils::numeric(FLERR, arg[1], false, lmp)))
    error->all(FLERR, "Illegal fix_modify {}: velocity belongs to a free plate (support free)", id);
  return 2;
}

/* Present position of the lower or upper plane. */

double FixWallGranHysteretic::level(int side) const
{
  if (!support || side != moving) return plane[side];
  return plane[side] + (side == 0 ? -1.0 : 1.0) * support->displacement();
}

double FixWallGranHysteretic::depth(int i, int side) const
{
  if (tube) return side == 0 ? -INFINITE : tube->overlap(atom->x[i], atom->radius[i]);
  const double along = atom->x[i][axis], radius = atom->radius[i];
  return side == 0 ? level(0) + radius - along : along + radius - level(1);
}

/* Unit normal of a wall at sphere i, into the packing. */

void FixWallGranHysteretic::inward(int i, int side, double normal[3]) const
{
  if (tube) return tube->inward(atom->x[i], normal);
  normal[0] = normal[1] = normal[2] = 0.0;
  normal[axis] = side == 0 ? 1.0 : -1.0;
}

/* Location of sphere i along the wall. */

void FixWallGranHysteretic::place_of(int i, double place[2]) const
{
  if (tube) return tube->place(atom->x[i], place);
  place[0] = atom->x[i][(axis + 1) % 3];
  place[1] = atom->x[i][(axis + 2) % 3];
}

/* Add a force on the wall to its total: along x, y, z, or outward, around and along a tube. */

void FixWallGranHysteretic::add_to_wall(int i, const double force[3])
{
  double along[3] = {force[0], force[1], force[2]};
  if (tube) tube->cylindrical(atom->x[i], force, along);
  for (int d = 0; d < 3; d++) wall_force[d] += along[d];
}

/* Sum the force on the plane over all processors, bitwise identical on each. */

void FixWallGranHysteretic::push_support()
{
  constexpr int n = granwave::ExactSum::SIZE;
  std::int64_t mine[2 * n], all[2 * n];
  std::copy_n(pressed.data(), n, mine);
  std::copy_n(stiffness.data(), n, mine + n);
  MPI_Allreduce(mine, all, 2 * n, MPI_INT64_T, MPI_SUM, world);
  std::copy_n(all, n, pressed.data());
  std::copy_n(all + n, n, stiffness.data());
  contact_stiffness = stiffness.value();
  support->push(pressed.value());
  if (update->whichflag == 1) check_timestep(contact_stiffness);
}

void FixWallGranHysteretic::check_timestep(double contacts) const
{
  if (!support || update->dt <= support->critical_timestep(contacts)) return;
  error->all(FLERR, "Fix {} {}: the timestep {:.4g} is beyond the critical one of the support{}, {:.4g}: shorten it", STYLE,
             id, update->dt, contacts > 0.0 ? " with the spheres on it" : "", support->critical_timestep(contacts));
}

/* ---------------------------------------------------------------------- forces */

void FixWallGranHysteretic::evaluate()
{
  double **f = atom->f;
  const double *const *x = atom->x;
  const double *radius = atom->radius;
  const double now = granwave::simulated_time(*update);
  const double at[2] = {level(0), level(1)};
  std::fill_n(wall_force, 3, 0.0);
  pressed = stiffness = {};
  tallied = -1;
  if (!listed || (support && std::fabs(level(moving) - listed_level) > 0.5 * neighbor->skin)) list_spheres();
  if (has_lines) compute_lines(at);
  for (std::size_t n = 0; n < spheres.size(); n++) {
    const int i = spheres[n];
    if (!(atom->mask[i] & groupbit) || radius[i] == 0.0) continue;    // flat faces do not interact with walls
    if (cylinders && stands[atom->type[i]]) continue;
    const double overlap[2] = {tube ? -INFINITE : at[0] + radius[i] - x[i][axis],
                               tube ? depth(i, 1) : x[i][axis] + radius[i] - at[1]};
    const double least = ROUNDING * radius[i];
    const bool touches[2] = {!(overlap[0] <= least), !(overlap[1] <= least)};    // also true for NaN
    if (!touches[0] && !touches[1] && !near[i]) continue;
    near[i] = touches[0] || touches[1];
    array_atom[i][OVERLAP] = array_atom[i][FORCE] = array_atom[i][TANGENTIAL] = 0.0;
    for (int side = 0; side < 2; side++) {
      Side &mine = sides[2 * i + side];
      if (!touches[side] && mine.touching == 0.0) continue;
      Contact contact{};
      if (touches[side]) {
        contact = compute_normal(i, side, overlap[side], now, 2 * n + side);
        if (tube) {
          double push[3];
          inward(i, side, push);
          for (int d = 0; d < 2; d++) f[i][d] += push[d] * contact.force;
          wall_force[0] += contact.force;    // outward
        } else {
          const double push = contact.force * (side == 0 ? 1.0 : -1.0);
          f[i][axis] += push;
          wall_force[axis] -= push;
        }
        if (support) {
          pressed.add(contact.force);
          stiffness.add(contact.stiffness);
        }
      } else {
        mine.touching = 0.0;
        if (loss) {
          viscous(i, side).release(overlap[side]);
          report_viscous(i);
        }
      }
      if (friction > 0.0) compute_tangential(i, side, overlap[side], contact);
    }
  }
  if (support) push_support();
}

/* Squared distance between two locations on the wall, to the nearest image. */

double FixWallGranHysteretic::distance_squared(const double from[2], const double to[2]) const
{
  double sum = 0.0;
  for (int d = 0; d < 2; d++) {
    const int along = (axis + 1 + d) % 3;
    double distance = to[d] - from[d], period = domain->periodicity[along] ? domain->prd[along] : 0.0;
    if (tube) period = d == 0 ? tube->circumference() : domain->periodicity[2] ? domain->prd[2] : 0.0;
    if (period > 0.0) distance -= period * std::round(distance / period);
    sum += distance * distance;
  }
  return sum;
}

/* Energy dissipated by yielding at one wall in this run. */

double FixWallGranHysteretic::lost(int i, int which, const ScaledLaw &scaled)
{
  const Side &side = sides[2 * i + which];
  return side.lost_before + scaled.dissipated_energy(law_history(i, which)) -
         scaled.dissipated_energy({side.initial, initial_extra(i, which)});
}

/* Compute the normal force of one wall on sphere i, which overlaps with it, and update its dent and its output. If the contact
   is along a line, its force is in line_force at the index `line`. */

FixWallGranHysteretic::Contact FixWallGranHysteretic::compute_normal(int i, int which, double overlap, double now,
                                                                     std::size_t line)
{
  double *const state = array_atom[i];
  Side &side = sides[2 * i + which];
  const double radius = atom->radius[i];
  if (!(overlap <= radius)) {
    granwave::require_finite_motion(lmp, i);
    error->one(FLERR,
               "Sphere {} reaches {:.3g} into the wall of fix {}, more than its radius {:.3g}: it was placed into "
               "it, or the timestep is far too large",
               atom->tag[i], overlap, id, radius);
  }
  if (tube && !tube->holds(radius))
    error->one(FLERR, "Fix {} {}: sphere {} of radius {:.6g} does not fit into the tube of radius {:.6g}", STYLE, id,
               atom->tag[i], radius, tube->radius());
  const ScaledLaw &scaled = scaled_law(i);
  const double effective = scaled.effective_radius();
  if (!(overlap < scaled.largest_overlap()))
    error->one(FLERR,
               "Cylinder {} reaches {:.3g} into the wall of fix {}, where the law of a line contact ends: it is too short",
               atom->tag[i], overlap, id);
  if (state[TIME_FIRST] < 0.0) state[TIME_FIRST] = now;
  if (side.touching == 0.0) {
    side.touching = 1.0;
    if (side.dent > 0.0) {
      const double circle_sq =
          std::isfinite(scaled.yield_overlap()) ? scaled.loading_circle(side.dent) : effective * side.dent;
      double place[2];
      place_of(i, place);
      if (distance_squared(side.place, place) > circle_sq) {
        side.lost_before = lost(i, which, scaled);
        side.dent = side.initial = 0.0;
        std::fill_n(extra(i, which), law.entry().n_extra, 0.0);
      }
    }
  }
  if (law.entry().n_extra > 0) scaled.update(overlap, side.dent, extra(i, which));
  const bool raised = overlap > side.dent;
  if (raised) {
    side.dent = overlap;
    place_of(i, side.place);
  }
  Contact contact{};
  if (scaled.line()) {
    contact.force = line_force[line];
    if (support) contact.stiffness = line_stiffness[line];
    if (friction > 0.0) contact.circle_sq = scaled.circle_squared(line_stiffness[line]);
  } else if (!scaled.yielded(side.dent)) {
    contact.force = scaled.hertz_force(overlap);
    if (support) contact.stiffness = scaled.is_hertzian() ? 1.5 * contact.force / overlap : scaled.hertz_stiffness(overlap);
    if (friction > 0.0)
      contact.circle_sq = scaled.is_hertzian() ? effective * overlap : scaled.circle_squared(overlap, law_history(i, which));
  } else {
    const granwave::Turning turning = scaled.turning(law_history(i, which));
    contact.force = raised ? scaled.peak_force(turning) : scaled.unloading(overlap, turning);
    if (support) contact.stiffness = scaled.stiffness(turning);
    if (friction > 0.0)
      contact.circle_sq =
          raised ? scaled.loading_circle(overlap) : scaled.unloading_circle(overlap, turning, law.area(turning.peak));
    if (raised) {
      if (state[TIME_YIELD] < 0.0) state[TIME_YIELD] = now;
      state[DISSIPATED] = lost(i, 0, scaled) + lost(i, 1, scaled);
    }
  }
  if (loss) compute_viscous(i, which, overlap, scaled, contact);
  if (contact.force > state[FORCE] || state[FORCE] == 0.0) {
    state[FORCE] = contact.force;
    state[OVERLAP] = overlap;
  }
  if (contact.force > state[PEAK_FORCE]) {
    state[PEAK_FORCE] = contact.force;
    state[TIME_PEAK] = now;
  }
  state[PEAK_OVERLAP] = std::max(state[PEAK_OVERLAP], overlap);
  return contact;
}

/* Add the viscous force of one wall on sphere i to the normal force, as the pair style does. */

void FixWallGranHysteretic::compute_viscous(int i, int which, double overlap, const ScaledLaw &scaled, Contact &contact)
{
  granwave::ViscousHistory &history = viscous(i, which);
  if (update->whichflag != 1) {
    history.forget_state();
    return;
  }
  const bool advances = !update->setupflag;
  if (!advances && history.continues(overlap, ROUNDING * atom->radius[i])) {
    contact.force += history.force;
    return;
  }
  const double coefficient = loss.coefficient(scaled.tangent_stiffness(overlap, law_history(i, which)), atom->rmass[i]);
  double normal[3], approach = 0.0;    // from the velocities
  inward(i, which, normal);
  for (int d = 0; d < 3; d++) approach -= normal[d] * atom->v[i][d];
  if (support && which == moving) approach -= support->velocity();
  contact.force += advances ? history.advance(overlap, contact.force, coefficient, approach, update->dt)
                            : history.start(overlap, contact.force, coefficient, approach, update->dt);
  report_viscous(i);
}

/* Update the column of the energy that the viscous forces of both walls took. */

void FixWallGranHysteretic::report_viscous(int i) { array_atom[i][VISCOUS] = viscous(i, 0).lost + viscous(i, 1).lost; }

/* Compute the tangential force of one wall on sphere i, and its torque. The spring is updated only if a timestep was made. */

void FixWallGranHysteretic::compute_tangential(int i, int which, double overlap, const Contact &contact)
{
  TangentialSpring &spring = springs[2 * i + which];
  double *const state = array_atom[i];
  if (contact.force > 0.0) {
    double normal[3];
    inward(i, which, normal);
    const double lever = atom->radius[i] - (cylinders && is_line(i) ? 1.0 : 0.5) * overlap;
    if (update->whichflag == 1 && !update->setupflag) {
      const double *const v = atom->v[i], *const omega = atom->omega[i];
      const double velocity[3] = {v[0], v[1], v[2]}, spin[3] = {lever * omega[0], lever * omega[1], lever * omega[2]};
      double slip[3];
      granwave::slip_of_step(velocity, spin, normal, update->dt, slip);
      granwave::compute_tangential(spring, normal, slip, law.tangential_stiffness(contact.circle_sq),
                                   friction * contact.force, tangential_model);
    }
    double torque[3];
    granwave::torque_per_lever(normal, spring.force, torque);
    for (int d = 0; d < 3; d++) {
      atom->f[i][d] += spring.force[d];
      atom->torque[i][d] += lever * torque[d];
    }
    const double on_wall[3] = {-spring.force[0], -spring.force[1], -spring.force[2]};
    add_to_wall(i, on_wall);
    if (contact.force == state[FORCE]) state[TANGENTIAL] = granwave::tangential_force(spring);
  } else {
    granwave::release(spring);
  }
  state[FRICTION_LOSS] = springs[2 * i].loss + springs[2 * i + 1].loss;
}
