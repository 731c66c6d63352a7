// SPDX-License-Identifier: GPL-2.0-only
/* Fix wall/gran/hysteretic: forces, motion of the plane, totals. Per-sphere state, initial dents and restart files are in
   fix_wall_gran_hysteretic_state.cpp. */

#include "fix_wall_gran_hysteretic.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "finite_motion.h"
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
  if (narg < 7) error->all(FLERR, "Illegal fix {}: expected xplane|yplane|zplane LO HI law and its constants", STYLE);
  axis = arg[3][0] - 'x';
  if (axis < 0 || axis > 2 || std::strcmp(arg[3] + 1, "plane") != 0)
    error->all(FLERR, "Illegal fix {}: expected xplane, yplane or zplane, found {}", STYLE, arg[3]);
  const double absent[2] = {-INFINITE, INFINITE};
  for (int side = 0; side < 2; side++)
    plane[side] = std::strcmp(arg[4 + side], "NULL") == 0 ? absent[side] : utils::numeric(FLERR, arg[4 + side], false, lmp);
  if (!(plane[0] < plane[1])) error->all(FLERR, "Illegal fix {}: LO must be below HI, found {} {}", STYLE, arg[4], arg[5]);
  std::vector<std::string> words(arg + 6, arg + narg);
  try {
    if (const auto at = std::find(words.begin(), words.end(), "support"); at != words.end()) {
      std::size_t used = 0;
      support = std::make_unique<granwave::Support>(std::vector<std::string>(at + 1, words.end()), used);
      words.erase(at, at + 1 + used);
      if (std::isfinite(plane[0]) && std::isfinite(plane[1]))
        throw std::invalid_argument("support moves one plane, found two: take a fix for each");
      if (!std::isfinite(plane[0]) && !std::isfinite(plane[1]))
        throw std::invalid_argument("support moves a plane, found none");
      moving = std::isfinite(plane[0]) ? 0 : 1;
    }
    const granwave::LawArguments args = granwave::parse_law(words);
    law = args.contact(args.first, args.second.value_or(granwave::Material{INFINITE, 0.0, INFINITE}));
    friction = args.friction;
    tangential_model = args.tangential;
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
  if (friction > 0.0 && !(atom->omega_flag && atom->torque_flag))
    error->all(FLERR, "Fix {} with friction requires atom attributes omega and torque (atom_style sphere)", STYLE);
  if (domain->periodicity[axis]) error->all(FLERR, "Fix {}: the box is periodic across the wall", STYLE);
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

/* Present position of the lower or upper plane. */

double FixWallGranHysteretic::level(int side) const
{
  if (!support || side != moving) return plane[side];
  return plane[side] + (side == 0 ? -1.0 : 1.0) * support->displacement();
}

double FixWallGranHysteretic::depth(int i, int side) const
{
  const double along = atom->x[i][axis], radius = atom->radius[i];
  return side == 0 ? level(0) + radius - along : along + radius - level(1);
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
  for (const int i : spheres) {
    if (!(atom->mask[i] & groupbit) || radius[i] == 0.0) continue;    // flat faces do not interact with walls
    const double overlap[2] = {at[0] + radius[i] - x[i][axis], x[i][axis] + radius[i] - at[1]};
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
        contact = compute_normal(i, side, overlap[side], now);
        const double push = contact.force * (side == 0 ? 1.0 : -1.0);
        f[i][axis] += push;
        wall_force[axis] -= push;
        if (support) {
          pressed.add(contact.force);
          stiffness.add(contact.stiffness);
        }
      } else {
        mine.touching = 0.0;
      }
      if (friction > 0.0) compute_tangential(i, side, overlap[side], contact);
    }
  }
  if (support) push_support();
}

/* Distance along an axis to the nearest image. */

double FixWallGranHysteretic::minimum_image(int along, double distance) const
{
  if (!domain->periodicity[along]) return distance;
  return distance - domain->prd[along] * std::round(distance / domain->prd[along]);
}

/* Energy dissipated by yielding at one wall in this run. */

double FixWallGranHysteretic::lost(int i, int which, const ScaledLaw &scaled)
{
  const Side &side = sides[2 * i + which];
  return side.lost_before + scaled.dissipated_energy(law_history(i, which)) -
         scaled.dissipated_energy({side.initial, initial_extra(i, which)});
}

/* Compute the normal force of one wall on sphere i, which overlaps with it, and update its dent and its output. */

FixWallGranHysteretic::Contact FixWallGranHysteretic::compute_normal(int i, int which, double overlap, double now)
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
  const ScaledLaw scaled(law, radius);
  const double place[2] = {atom->x[i][(axis + 1) % 3], atom->x[i][(axis + 2) % 3]};
  if (state[TIME_FIRST] < 0.0) state[TIME_FIRST] = now;
  if (side.touching == 0.0) {
    side.touching = 1.0;
    if (side.dent > 0.0) {
      const double circle_sq = std::isfinite(scaled.yield_overlap()) ? scaled.loading_circle(side.dent) : radius * side.dent;
      const double d1 = minimum_image((axis + 1) % 3, place[0] - side.place[0]),
                   d2 = minimum_image((axis + 2) % 3, place[1] - side.place[1]);
      if (d1 * d1 + d2 * d2 > circle_sq) {
        side.lost_before = lost(i, which, scaled);
        side.dent = side.initial = 0.0;
        std::fill_n(extra(i, which), n_extra(), 0.0);
      }
    }
  }
  if (n_extra() > 0) scaled.update(overlap, side.dent, extra(i, which));
  const bool raised = overlap > side.dent;
  if (raised) {
    side.dent = overlap;
    side.place[0] = place[0];
    side.place[1] = place[1];
  }
  Contact contact{};
  if (!scaled.yielded(side.dent)) {
    contact.force = scaled.hertz_force(overlap);
    if (support) contact.stiffness = 1.5 * contact.force / overlap;
    contact.circle_sq = radius * overlap;
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

/* Compute the tangential force of one wall on sphere i, and its torque. The spring is updated only if a timestep was made. */

void FixWallGranHysteretic::compute_tangential(int i, int which, double overlap, const Contact &contact)
{
  TangentialSpring &spring = springs[2 * i + which];
  double *const state = array_atom[i];
  if (contact.force > 0.0) {
    double normal[3] = {};
    normal[axis] = which == 0 ? 1.0 : -1.0;
    const double lever = atom->radius[i] - 0.5 * overlap;
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
      wall_force[d] -= spring.force[d];
    }
    if (contact.force == state[FORCE]) state[TANGENTIAL] = granwave::tangential_force(spring);
  } else {
    granwave::release(spring);
  }
  state[FRICTION_LOSS] = springs[2 * i].loss + springs[2 * i + 1].loss;
}

/* ---------------------------------------------------------------------- totals */

void FixWallGranHysteretic::tally()
{
  if (tallied == update->ntimestep) return;
  tallied = update->ntimestep;
  double mine[N_TOTALS] = {};
  for (int i = 0; i < atom->nlocal; i++) {
    const double *state = array_atom[i];
    if (state[PEAK_OVERLAP] == 0.0) continue;
    const double radius = atom->radius[i];
    const ScaledLaw scaled(law, radius);
    mine[DISSIPATED_SUM] += state[DISSIPATED];
    mine[FRICTION_LOSS_SUM] += state[FRICTION_LOSS];
    if (law.entry().yields() && state[TIME_YIELD] >= 0.0) mine[YIELDED] += 1.0;
    if (law.entry().fitted && state[PEAK_OVERLAP] > 0.2 * radius) mine[BEYOND_LAW] += 1.0;
    for (int side = 0; side < 2; side++) {
      const Side &own = sides[2 * i + side];
      const double overlap = depth(i, side);
      if (friction > 0.0) mine[TANGENTIAL_STORED] += granwave::tangential_energy(springs[2 * i + side]);
      if (own.touching == 0.0 || overlap <= 0.0) continue;
      mine[STORED] += scaled.elastic_energy(overlap, law_history(i, side));
    }
  }
  MPI_Allreduce(mine, totals, N_TOTALS, MPI_DOUBLE, MPI_SUM, world);
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
  if (n < 3 + N_TOTALS) {
    tally();
    return totals[n - 3];
  }
  if (!support) return 0.0;
  switch (n - 3 - N_TOTALS) {
    case 0:
      return support->displacement();
    case 1:
      return support->velocity();
    case 2:
      return support->energy();
    case 3:
      return support->damped();
    case 4:
      return support->force_on_ground();
    default:
      return support->work();
  }
}
