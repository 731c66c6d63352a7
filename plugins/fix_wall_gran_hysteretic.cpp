#include "fix_wall_gran_hysteretic.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "law_arguments.h"
#include "memory.h"
#include "simulated_time.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using granwave::ContactScale;
using granwave::INFINITE;
using granwave::Turning;

namespace {

// columns of array_atom, what is reported of a sphere, and of `sides`, the state of its dent on the low and high wall
enum { OVERLAP, FORCE, PEAK_OVERLAP, PEAK_FORCE, DISSIPATED, TIME_FIRST, TIME_PEAK, TIME_YIELD, N_REPORTED };
enum { DENT, PLACE_1, PLACE_2, LOST_BEFORE, TOUCHING, N_SIDE };
constexpr int N_SIDES = 2 * N_SIDE, N_STATE = N_REPORTED + N_SIDES;
constexpr int RESTART_FORMAT = 1;
constexpr double ROUNDING = 1e-12;    // of the radius: overlaps below are rounding of positions

}    // namespace

FixWallGranHysteretic::FixWallGranHysteretic(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg < 7)
    error->all(FLERR, "Illegal fix {}: expected xplane|yplane|zplane LO HI law and its constants", STYLE);
  axis = arg[3][0] - 'x';
  if (axis < 0 || axis > 2 || std::strcmp(arg[3] + 1, "plane") != 0)
    error->all(FLERR, "Illegal fix {}: expected xplane, yplane or zplane, found {}", STYLE, arg[3]);
  const double absent[2] = {-INFINITE, INFINITE};
  for (int side = 0; side < 2; side++)
    plane[side] = std::strcmp(arg[4 + side], "NULL") == 0 ? absent[side] : utils::numeric(FLERR, arg[4 + side], false, lmp);
  if (!(plane[0] < plane[1])) error->all(FLERR, "Illegal fix {}: LO must be below HI, found {} {}", STYLE, arg[4], arg[5]);
  try {
    const granwave::LawArguments args = granwave::parse_law(std::vector<std::string>(arg + 6, arg + narg));
    law = args.contact(args.first, args.second.value_or(granwave::Material{INFINITE, 0.0, INFINITE}));
  } catch (const std::invalid_argument &fault) {
    error->all(FLERR, "Illegal fix {}: {}", STYLE, fault.what());
  }

  restart_peratom = 1;
  create_attribute = 1;
  scalar_flag = vector_flag = 1;
  size_vector = 7;
  global_freq = 1;
  extscalar = extvector = 1;
  peratom_flag = 1;
  size_peratom_cols = N_REPORTED;
  peratom_freq = 1;
  maxexchange = N_STATE;
  std::fill_n(wall_force, 3, 0.0);
  std::fill_n(totals, 4, 0.0);

  FixWallGranHysteretic::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
  for (int i = 0; i < atom->nlocal; i++) FixWallGranHysteretic::set_arrays(i);
}

FixWallGranHysteretic::~FixWallGranHysteretic()
{
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
  memory->destroy(array_atom);
  memory->destroy(sides);
}

int FixWallGranHysteretic::setmask() { return FixConst::POST_FORCE | FixConst::MIN_POST_FORCE; }

void FixWallGranHysteretic::init()
{
  if (std::strncmp(update->integrate_style, "respa", 5) == 0)
    error->all(FLERR, "Fix {} does not work with run_style respa", STYLE);
  if (!atom->radius_flag) error->all(FLERR, "Fix {} requires atom attribute radius (atom_style sphere)", STYLE);
  if (domain->periodicity[axis]) error->all(FLERR, "Fix {}: the box is periodic across the wall", STYLE);
}

void FixWallGranHysteretic::setup(int vflag) { post_force(vflag); }
void FixWallGranHysteretic::min_setup(int vflag) { post_force(vflag); }
void FixWallGranHysteretic::min_post_force(int vflag) { post_force(vflag); }

void FixWallGranHysteretic::post_force(int)
{
  const double *const *x = atom->x;
  double **f = atom->f;
  const double *radius = atom->radius;
  const double now = granwave::simulated_time(*update);
  std::fill_n(wall_force, 3, 0.0);
  tallied = -1;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit) || radius[i] == 0.0) continue;    // a flat face meets no wall
    const double depth[2] = {plane[0] + radius[i] - x[i][axis], x[i][axis] + radius[i] - plane[1]};
    double *state = array_atom[i];
    bool reset = true;    // the report of what is now starts from nothing, once
    for (int side = 0; side < 2; side++) {
      double *mine = sides[i] + side * N_SIDE;
      const bool touches = depth[side] > ROUNDING * radius[i];
      if (!touches && mine[TOUCHING] == 0.0) continue;
      if (reset) state[OVERLAP] = state[FORCE] = 0.0;
      reset = false;
      if (!touches) {
        mine[TOUCHING] = 0.0;
        continue;
      }
      const double push = touch(i, side, depth[side], now) * (side == 0 ? 1.0 : -1.0);
      f[i][axis] += push;
      wall_force[axis] -= push;
    }
  }
}

/* The distance along an axis to the nearest image. */

double FixWallGranHysteretic::apart(int along, double distance) const
{
  if (!domain->periodicity[along]) return distance;
  return distance - domain->prd[along] * std::round(distance / domain->prd[along]);
}

/* The force of sphere i on one wall that it overlaps; keeps its dent and its report. */

double FixWallGranHysteretic::touch(int i, int which, double overlap, double now)
{
  double *const state = array_atom[i], *const side = sides[i] + which * N_SIDE, *const other = sides[i] + (1 - which) * N_SIDE;
  const double radius = atom->radius[i];
  if (overlap > radius)
    error->one(FLERR, "Sphere {} reaches {:.3g} into the wall of fix {}, more than its radius {:.3g}: it was placed into "
                      "it, or the timestep is far too large", atom->tag[i], overlap, id, radius);
  const ContactScale scale = law.scale(radius);
  const double place[2] = {atom->x[i][(axis + 1) % 3], atom->x[i][(axis + 2) % 3]};
  if (side[TOUCHING] == 0.0) {
    side[TOUCHING] = 1.0;
    const double peak = side[DENT];
    if (peak > 0.0) {
      const double circle_sq = std::isfinite(scale.overlap) ? radius * scale.overlap * law.area(peak / scale.overlap) : radius * peak;
      const double d1 = apart((axis + 1) % 3, place[0] - side[PLACE_1]), d2 = apart((axis + 2) % 3, place[1] - side[PLACE_2]);
      if (d1 * d1 + d2 * d2 > circle_sq) {
        if (peak > scale.elastic_limit)
          side[LOST_BEFORE] += scale.force * scale.overlap * law.dissipated_energy(law.turning(peak / scale.overlap));
        side[DENT] = 0.0;
      }
    }
  }
  const bool raised = overlap > side[DENT];
  if (raised) {
    side[DENT] = overlap;
    side[PLACE_1] = place[0];
    side[PLACE_2] = place[1];
    if (state[TIME_FIRST] < 0.0) state[TIME_FIRST] = now;
  }
  double force;
  if (side[DENT] <= scale.elastic_limit) {
    force = scale.hertz * overlap * std::sqrt(overlap);
  } else {
    const Turning turning = law.turning(side[DENT] / scale.overlap);
    force = scale.force * (raised ? turning.force : granwave::ContactLaw::unloading(overlap / scale.overlap, turning));
    if (state[TIME_YIELD] < 0.0) state[TIME_YIELD] = now;
    if (raised) {
      state[DISSIPATED] = scale.force * scale.overlap * law.dissipated_energy(turning);
      state[DISSIPATED] += side[LOST_BEFORE] + other[LOST_BEFORE];
      if (other[DENT] > scale.elastic_limit)
        state[DISSIPATED] += scale.force * scale.overlap * law.dissipated_energy(law.turning(other[DENT] / scale.overlap));
    }
  }
  if (force > state[FORCE] || state[FORCE] == 0.0) {
    state[FORCE] = force;
    state[OVERLAP] = overlap;
  }
  if (force > state[PEAK_FORCE]) {
    state[PEAK_FORCE] = force;
    state[TIME_PEAK] = now;
  }
  state[PEAK_OVERLAP] = std::max(state[PEAK_OVERLAP], overlap);
  return force;
}

void FixWallGranHysteretic::tally()
{
  if (tallied == update->ntimestep) return;
  tallied = update->ntimestep;
  double mine[4] = {};
  const double *const *x = atom->x;
  for (int i = 0; i < atom->nlocal; i++) {
    const double *state = array_atom[i];
    if (state[PEAK_OVERLAP] == 0.0) continue;
    const double radius = atom->radius[i];
    const ContactScale scale = law.scale(radius);
    mine[1] += state[DISSIPATED];
    if (state[PEAK_OVERLAP] > scale.elastic_limit) mine[2] += 1.0;
    if (law.fitted() && state[PEAK_OVERLAP] > 0.2 * radius) mine[3] += 1.0;
    const double depth[2] = {plane[0] + radius - x[i][axis], x[i][axis] + radius - plane[1]};
    for (int side = 0; side < 2; side++) {
      const double *own = sides[i] + side * N_SIDE;
      if (own[TOUCHING] == 0.0 || depth[side] <= 0.0) continue;
      if (own[DENT] > scale.elastic_limit)
        mine[0] += scale.force * scale.overlap *
            granwave::ContactLaw::elastic_energy(depth[side] / scale.overlap, law.turning(own[DENT] / scale.overlap));
      else
        mine[0] += 0.4 * scale.hertz * depth[side] * depth[side] * std::sqrt(depth[side]);
    }
  }
  MPI_Allreduce(mine, totals, 4, MPI_DOUBLE, MPI_SUM, world);
}

double FixWallGranHysteretic::compute_scalar()
{
  tally();
  return totals[0];
}

double FixWallGranHysteretic::compute_vector(int n)
{
  if (n >= 3) {
    tally();
    return totals[n - 3];
  }
  double sum = 0.0;
  MPI_Allreduce(&wall_force[n], &sum, 1, MPI_DOUBLE, MPI_SUM, world);
  return sum;
}

/* ---------------------------------------------------------------------- the state travels with the spheres */

void FixWallGranHysteretic::grow_arrays(int nmax)
{
  memory->grow(array_atom, nmax, static_cast<int>(N_REPORTED), "wall/gran/hysteretic:array_atom");
  memory->grow(sides, nmax, N_SIDES, "wall/gran/hysteretic:sides");
}

void FixWallGranHysteretic::copy_arrays(int i, int j, int)
{
  std::copy_n(array_atom[i], static_cast<int>(N_REPORTED), array_atom[j]);
  std::copy_n(sides[i], N_SIDES, sides[j]);
}

void FixWallGranHysteretic::set_arrays(int i)
{
  std::fill_n(array_atom[i], static_cast<int>(N_REPORTED), 0.0);
  array_atom[i][TIME_FIRST] = array_atom[i][TIME_PEAK] = array_atom[i][TIME_YIELD] = -1.0;
  std::fill_n(sides[i], N_SIDES, 0.0);
}

int FixWallGranHysteretic::pack_exchange(int i, double *buf)
{
  std::copy_n(array_atom[i], static_cast<int>(N_REPORTED), buf);
  std::copy_n(sides[i], N_SIDES, buf + N_REPORTED);
  return N_STATE;
}

int FixWallGranHysteretic::unpack_exchange(int i, double *buf)
{
  std::copy_n(buf, static_cast<int>(N_REPORTED), array_atom[i]);
  std::copy_n(buf + N_REPORTED, N_SIDES, sides[i]);
  return N_STATE;
}

int FixWallGranHysteretic::pack_restart(int i, double *buf)
{
  buf[0] = N_STATE + 2;
  buf[1] = RESTART_FORMAT;
  pack_exchange(i, buf + 2);
  return N_STATE + 2;
}

void FixWallGranHysteretic::unpack_restart(int nlocal, int nth)
{
  double **extra = atom->extra;
  int m = 0;
  for (int i = 0; i < nth; i++) m += static_cast<int>(extra[nlocal][m]);
  if (extra[nlocal][m + 1] != RESTART_FORMAT)
    error->one(FLERR, "Restart file holds format {} of fix {}; this version reads format {}", extra[nlocal][m + 1], STYLE, RESTART_FORMAT);
  unpack_exchange(nlocal, &extra[nlocal][m + 2]);
}

int FixWallGranHysteretic::size_restart(int) { return N_STATE + 2; }
int FixWallGranHysteretic::maxsize_restart() { return N_STATE + 2; }
double FixWallGranHysteretic::memory_usage() { return double(atom->nmax) * N_STATE * sizeof(double); }
