// SPDX-License-Identifier: GPL-2.0-only
/* Fix wall/gran/hysteretic: spheres within reach, per-sphere state, initial dents, restart files. */

#include "fix_wall_gran_hysteretic.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "memory.h"
#include "neighbor.h"
#include "restart_state.h"

#include <cstring>

using namespace LAMMPS_NS;
using namespace granwave;

constexpr int N_NEW = 1;    // numbers in a restart file of a sphere that has not touched a wall
constexpr double ROUNDING_OF_AXIS = 1e-9, VALID_LINE = 0.1;    // largest overlap of a line contact / radius

FixWallGranHysteretic::~FixWallGranHysteretic()
{
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
  memory->destroy(array_atom);
}

/* ---------------------------------------------------------------------- spheres within reach */

/* True for spheres of the group; flat faces and cylinders that stand on the wall do not interact with it. */
bool FixWallGranHysteretic::meets_walls(int i) const
{
  return (atom->mask[i] & groupbit) && atom->radius[i] != 0.0 && !(cylinders && stands[atom->type[i]]);
}

/* List the spheres that can reach a wall before the next reneighboring: until then no sphere moves by more than half the skin
   of the neighbor lists. The other half is for the motion of the plane. */
void FixWallGranHysteretic::list_spheres()
{
  const double *const *x = atom->x;
  const double *radius = atom->radius;
  const double reach[2] = {level(0) + neighbor->skin, level(1) - neighbor->skin};
  listed_level = level(moving);
  spheres.clear();
  for (int i = 0; i < atom->nlocal; i++)
    if (near[i] || (curved ? !(depth(i, 1) < -neighbor->skin)
                           : !(x[i][axis] - radius[i] > reach[0] && x[i][axis] + radius[i] < reach[1])))
      spheres.push_back(i);
  listed = true;
}

/* ---------------------------------------------------------------------- cylinders */

/* Determine the cylinders that touch the wall along a line. */
void FixWallGranHysteretic::init_cylinders()
{
  cylinders = FixGranCylinder::find(lmp);
  lines.clear();
  last_laws.clear();
  has_lines = false;
  stands.assign(atom->ntypes + 1, 0);
  admitted.assign(atom->ntypes + 1, 0);
  if (!cylinders) return;
  std::vector<int> mine(atom->ntypes + 1, 0), present(atom->ntypes + 1, 0);
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) mine[atom->type[i]] = 1;
  MPI_Allreduce(mine.data(), present.data(), atom->ntypes + 1, MPI_INT, MPI_MAX, world);
  for (int type = 1; type <= atom->ntypes; type++)
    if (present[type]) admit_type(type);
}

/* Determine how atoms of a type touch the wall, if they are cylinders. Some may come, or change their type, during a run. */
void FixWallGranHysteretic::admit_type(int type)
{
  const Cylinder &cylinder = cylinders->shape(type);
  if (cylinder.is_sphere() || admitted[type]) return;
  admitted[type] = 1;
  if (has.cohesion) error->one(FLERR, "Fix {} {}: cohesion requires spheres, found cylinders of type {}", STYLE, id, type);
  if (curved)
    error->one(FLERR, "Fix {} {}: a {} holds spheres, found cylinders of type {}", STYLE, id, curved->kind(), type);
  const double along = std::fabs(cylinder.axis[axis]);
  stands[type] = along > 1.0 - ROUNDING_OF_AXIS;
  has_lines = has_lines || !stands[type];
  if (!stands[type] && along > ROUNDING_OF_AXIS)
    error->one(FLERR,
               "Fix {} {}: cylinders of type {} are oblique to the wall; expected their axis parallel or normal to it",
               STYLE, id, type);
}

/* True for a cylinder, which touches the wall along a line. */
bool FixWallGranHysteretic::is_line(int i) const { return !cylinders->shape(atom->type[i]).is_sphere(); }

/* Law of the contact of sphere or cylinder i with the wall; for each type the last law is cached. */
const ScaledLaw &FixWallGranHysteretic::scaled_law(int i)
{
  const double radius = atom->radius[i];
  const int type = atom->type[i];
  if (type >= static_cast<int>(last_laws.size())) last_laws.resize(atom->ntypes + 1);
  LastLaw &last = last_laws[type];
  if (last.radius == radius) return last.scaled;
  last.radius = radius;
  if (!cylinders || !is_line(i)) {
    const double effective = curved ? curved->effective_radius(radius) : radius;
    return last.scaled = ScaledLaw(law, effective, effective, INFINITE);
  }
  auto found = lines.find({type, radius});
  if (found == lines.end()) {
    const double length = cylinders->shape(type).length;
    const LineContact line = plane_strain ? LineContact::plane_strain(body, wall, radius, INFINITE, length)
                                          : LineContact(body, wall, 2.0 * radius, length);
    found = lines.emplace(std::pair(type, radius), ElasticContact(line, VALID_LINE * radius)).first;
  }
  return last.scaled = {law, radius, found->second};
}

/* Compute the forces of the cylinders on the list that touch planes in these places. */
void FixWallGranHysteretic::compute_lines(const double at[2])
{
  line_force.resize(2 * spheres.size());
  line_stiffness.resize(2 * spheres.size());
  const auto compute = [this] {
    line_batch.compute();
    for (int n = 0; n < line_batch.size; n++) {
      line_force[line_batch.place[n]] = line_batch.force[n];
      line_stiffness[line_batch.place[n]] = line_batch.stiffness[n];
    }
    line_batch.size = 0;
  };
  for (int n = 0; n < static_cast<int>(spheres.size()); n++) {
    const int i = spheres[n];
    if (!(atom->mask[i] & groupbit) || !is_line(i) || stands[atom->type[i]]) continue;
    const double along = atom->x[i][axis], radius = atom->radius[i];
    const double overlap[2] = {at[0] + radius - along, along + radius - at[1]};
    for (int side = 0; side < 2; side++) {
      const LineContact *const line = overlap[side] > 0.0 ? scaled_law(i).line() : nullptr;
      if (!line) continue;
      line_batch.add(2 * n + side, *line, overlap[side]);
      if (line_batch.full()) compute();
    }
  }
  compute();
}

/* ---------------------------------------------------------------------- initial dents */

/* Stop with an error if a sphere cannot have a dent of this depth. */
void FixWallGranHysteretic::require_dented(int i, double peak)
{
  const double radius = atom->radius[i];
  if (!(atom->mask[i] & groupbit) || radius == 0.0)
    error->one(FLERR, "Fix {} {}: sphere {} cannot have a dent: it is not in the group of the fix, or its radius is 0",
               STYLE, id, atom->tag[i]);
  if (!(peak >= 0.0 && peak <= radius))
    error->one(FLERR, "Fix {} {}: a dent of sphere {} must lie between 0 and its radius {:.4g}, found {:.4g}", STYLE, id,
               atom->tag[i], radius, peak);
}

void FixWallGranHysteretic::set_dent(int i, double peak)
{
  require_dented(i, peak);
  const int which = nearer(i);
  Side &side = histories.side(i, which);
  side.dent = peak;
  place_of(i, side.place);
  side.initial = peak > scaled_law(i).elastic_limit() ? peak : 0.0;
  side.lost_before = 0.0;
  std::fill_n(extra(i, which), law.n_extra(), 0.0);
  std::fill_n(initial_extra(i, which), law.n_extra(), 0.0);
  report_dents(i);
}

bool FixWallGranHysteretic::set_contact(int i, const KnownContact &contact)
{
  require_dented(i, contact.peak);
  if (curved && curved->is_in_space())
    error->one(FLERR, "Fix {} {}: {} takes dents of a file, found a whole contact", STYLE, id,
               std::strcmp(curved->kind(), "region") == 0 ? "a face of a region" : "a mesh");
  if (!has.takes(contact)) return false;
  const int which = nearer(i);
  const bool yielded = scaled_law(i).yielded(contact.peak);
  Side &side = histories.side(i, which);
  side = Side();
  side.dent = contact.peak;
  std::copy_n(contact.place, 2, side.place);
  side.touching = depth(i, which) > ROUNDING * atom->radius[i] ? 1.0 : 0.0;
  side.initial = yielded ? contact.peak : 0.0;
  std::fill_n(extra(i, which), has.n, 0.0);
  std::copy(contact.block.begin(), contact.block.end(), extra(i, which));
  has.begin(extra(i, which), yielded);
  std::copy_n(extra(i, which), law.n_extra(), initial_extra(i, which));
  if (friction > 0.0) {
    TangentialSpring &spring = histories.spring(i, which);
    spring = TangentialSpring();
    std::copy_n(contact.force, 3, spring.force);
    spring.compliance = contact.compliance;
  }
  near[i] = 1;
  listed = false;
  report_dents(i);
  return true;
}

void FixWallGranHysteretic::begin(bool keeps)
{
  for (int i = 0; i < atom->nlocal; i++) {
    const ScaledLaw &scaled = scaled_law(i);
    double *const state = array_atom[i];
    state[PEAK_FORCE] = state[FRICTION_LOSS] = 0.0;
    state[TIME_FIRST] = state[TIME_PEAK] = state[TIME_YIELD] = -1.0;
    fronts[i] = Front();
    for (int which = 0; which < 2; which++) {
      Side &side = histories.side(i, which);
      const bool yielded = keeps && scaled.yielded(side.dent);
      const double rounding = ROUNDING * atom->radius[i];
      side.initial = yielded ? side.dent : 0.0;
      if (side.touching == 0.0 && !yielded) side.dent = 0.0;
      else if (!keeps) side.dent = rounding;
      else if (!yielded) side.dent = std::max(depth(i, which), has.cohesion ? rounding : 0.0);
      side.lost_before = 0.0;
      has.begin(extra(i, which), yielded);
      std::copy_n(extra(i, which), law.n_extra(), initial_extra(i, which));
      if (friction > 0.0) histories.spring(i, which).loss = 0.0;
    }
    state[VISCOUS] = 0.0;
    report_dents(i);
  }
  if (support) support->begin();
  tallied = -1;
}

/* Update the columns that depend on the dents only. */
void FixWallGranHysteretic::report_dents(int i)
{
  const ScaledLaw &scaled = scaled_law(i);
  const Side &low = histories.side(i, 0), &high = histories.side(i, 1);
  array_atom[i][PEAK_OVERLAP] = std::max(low.dent, high.dent);
  touched[i] = 1;
  array_atom[i][INITIAL] = std::max(low.initial, high.initial);
  array_atom[i][DISSIPATED] = lost(i, 0, scaled) + lost(i, 1, scaled);
  tallied = -1;
}

/* ---------------------------------------------------------------------- per-sphere state: migration and restart */

void FixWallGranHysteretic::grow_arrays(int nmax)
{
  memory->grow(array_atom, nmax, static_cast<int>(N_REPORTED), "wall/gran/hysteretic:array_atom");
  near.resize(nmax);
  touched.resize(nmax);
  histories.resize(nmax);
  fronts.resize(nmax);
}

void FixWallGranHysteretic::copy_arrays(int i, int j, int)
{
  near[j] = touched[j] = 1;
  listed = false;
  std::copy_n(array_atom[i], static_cast<int>(N_REPORTED), array_atom[j]);
  histories.take(histories, i, j);
  fronts[j] = fronts[i];
}

void FixWallGranHysteretic::set_arrays(int i)
{
  near[i] = touched[i] = 1;
  listed = false;
  reset_reported(array_atom[i]);
  histories.forget(i);
  fronts[i] = Front();
}

/* Set the reported values of a sphere that has not touched a wall. */
void FixWallGranHysteretic::reset_reported(double *reported)
{
  std::fill_n(reported, static_cast<int>(N_REPORTED), 0.0);
  reported[TIME_FIRST] = reported[TIME_PEAK] = reported[TIME_YIELD] = -1.0;
}

/* True if the state of sphere i is that of one that has not touched a wall. */
bool FixWallGranHysteretic::is_new(int i) const
{
  double reported[N_REPORTED];
  reset_reported(reported);
  const Front front;
  return std::memcmp(reported, array_atom[i], sizeof(reported)) == 0 &&
         std::memcmp(front.time, fronts[i].time, sizeof(front.time)) == 0 && histories.is_new(i);
}

int FixWallGranHysteretic::pack_exchange(int i, double *buf)
{
  double *at = std::copy_n(array_atom[i], static_cast<int>(N_REPORTED), buf);
  at = std::copy_n(fronts[i].time, static_cast<int>(Front::LEVELS), at);
  histories.pack(i, at);
  return n_state();
}

/* Read the reported values of a sphere, and its front. */
void FixWallGranHysteretic::unpack_reported(int i, const double *values)
{
  std::copy_n(values, static_cast<int>(N_REPORTED), array_atom[i]);
  std::copy_n(values + N_REPORTED, static_cast<int>(Front::LEVELS), fronts[i].time);
}

int FixWallGranHysteretic::unpack_exchange(int i, double *buf)
{
  near[i] = touched[i] = 1;
  listed = false;
  unpack_reported(i, buf);
  histories.unpack(i, buf + N_REPORTED + Front::LEVELS);
  return n_state();
}

/* Of a sphere that has not touched a wall, only the size that its state would have is written. */
int FixWallGranHysteretic::pack_restart(int i, double *buf)
{
  double *const state = buf + AtomState::HEAD;
  if (!is_new(i)) return seal_atom_state(lmp, i, buf, pack_exchange(i, state));
  state[0] = n_state();
  return seal_atom_state(lmp, i, buf, N_NEW);
}

void FixWallGranHysteretic::unpack_restart(int i, int nth)
{
  const AtomState state = atom_state(lmp, *this, i, nth);
  constexpr int N_BEFORE = N_REPORTED + Front::LEVELS;
  constexpr int N_BASIC = N_BEFORE + WallHistory::N_SIDES;
  const int n = state.n == N_NEW ? static_cast<int>(state.values[0]) : state.n;
  const bool whole = has.n == 0 && (n == N_BASIC || n == N_BASIC + WallHistory::N_SPRINGS);    // friction is new, or gone
  if (!whole && n != n_state())
    error->one(
        FLERR,
        "Restart file contains fix {} {} with another law or friction: define it again with the arguments of the file",
        STYLE, id);
  FixWallGranHysteretic::set_arrays(i);
  if (state.n == N_NEW) return;
  unpack_reported(i, state.values);
  histories.unpack(i, state.values + N_BEFORE, state.n == N_BASIC);
}

int FixWallGranHysteretic::size_restart(int i) { return AtomState::HEAD + (is_new(i) ? N_NEW : n_state()); }

int FixWallGranHysteretic::maxsize_restart() { return AtomState::HEAD + n_state(); }

double FixWallGranHysteretic::memory_usage()
{
  return double(atom->nmax) * (n_state() * sizeof(double) + 2) + double(spheres.capacity()) * sizeof(int);
}

/* ---------------------------------------------------------------------- state of the plane, identical on all processors */

void FixWallGranHysteretic::write_restart(FILE *fp)
{
  if (comm->me != 0 || !support) return;
  std::vector<double> state = support->state();
  state.insert(state.begin(), double(state.size()));
  write_state(fp, state);
}

void FixWallGranHysteretic::restart(char *buffer)
{
  const char *const other = support ? "another number of elements in its support" : "a support";
  const std::size_t n = support ? support->state_size() : 0;
  const std::vector<double> state = read_state(lmp, *this, buffer, 1 + n, other);
  if (!support || state[0] != static_cast<double>(n))
    error->all(FLERR, "Restart file contains fix {} {} with {}: define it again with the arguments of the file", STYLE, id,
               other);
  support->restore(state.data() + 1);
}
