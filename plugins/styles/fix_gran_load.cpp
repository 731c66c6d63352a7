// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_load.h"

#include "comm.h"
#include "error.h"
#include "fix_gran_timestep.h"
#include "group.h"
#include "modify.h"
#include "motion.h"
#include "restart_state.h"

#include <cstdlib>
#include <map>

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

constexpr const char *USAGE =
    "expected x|y|z|vector DX DY DZ, then force half-sine|rectangle AMPLITUDE DURATION, or force|displacement and one of "
    "harmonic AMPLITUDE "
    "FREQUENCY [RAMP], burst AMPLITUDE FREQUENCY CYCLES, up-and-down AMPLITUDE FREQUENCY DURATION, sweep AMPLITUDE FIRST "
    "LAST DURATION RAMP, noise AMPLITUDE FIRST LAST "
    "DURATION RAMP SEED, table FILE";

// relative tolerance of the mass of a group, whose sum depends on the order of its atoms
constexpr double ROUNDING = 1e-12;

/* Numbers of a shape: their names, and how many may be left out. */
struct Words {
  std::vector<const char *> names;
  int optional = 0;
};

const std::map<std::string, Words> SHAPES = {
    {"half-sine", {{"amplitude", "duration"}}},
    {"rectangle", {{"amplitude", "duration"}}},
    {"harmonic", {{"amplitude", "frequency", "ramp"}, 1}},
    {"burst", {{"amplitude", "frequency", "number of cycles"}}},
    {"up-and-down", {{"amplitude", "frequency", "duration"}}},
    {"sweep", {{"amplitude", "first frequency", "last frequency", "duration", "ramp"}}},
    {"noise", {{"amplitude", "first frequency", "last frequency", "duration", "ramp", "seed"}}},
    {"table", {{"file"}}},
};

}    // namespace

FixGranLoad::FixGranLoad(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg < 7) error->all(FLERR, "Illegal fix {}: {}", STYLE, USAGE);
  const int skipped = read_direction(narg, arg);
  narg -= skipped;
  arg += skipped;
  const std::string kind = arg[4], form = arg[5];
  if (kind != "force" && kind != "displacement")
    error->all(FLERR, "Illegal fix {}: '{}' is neither force nor displacement; {}", STYLE, kind, USAGE);
  moves = kind == "displacement";
  const auto known = SHAPES.find(form);
  const bool pulse = form == "half-sine" || form == "rectangle";
  if (known == SHAPES.end() || (pulse && moves))
    error->all(FLERR, "Illegal fix {}: '{}' is not a shape of a {}; {}", STYLE, form, kind, USAGE);
  const auto &[names, optional] = known->second;
  const int most = static_cast<int>(names.size());
  if (narg - 6 > most || narg - 6 < most - optional)
    error->all(FLERR, "Illegal fix {}: found {} arguments after '{}'; {}", STYLE, narg - 6, form, USAGE);
  if (form == "table") {
    read_table(arg[6]);
  } else {
    std::vector<double> numbers;
    for (int k = 6; k < narg; k++) {
      const std::string name = names[k - 6];
      numbers.push_back(positive_number(lmp, STYLE, name, arg[k], name == "ramp" || name == "seed"));
    }
    const bool ends = form == "sweep" || form == "noise";
    if (ends && 2.0 * numbers[4] > numbers[3])
      error->all(FLERR, "Illegal fix {}: the ramp must be at most half the duration, found {} of {}", STYLE, arg[10],
                 arg[9]);
    try {
      shape = LoadShape::named(form, numbers);
    } catch (const std::invalid_argument &fault) {
      error->all(FLERR, "Illegal fix {}: {} cannot be used: {}", STYLE, form, fault.what());
    }
  }

  restart_global = 1;
  time_integrate = moves ? 1 : 0;
  scalar_flag = vector_flag = 1;
  size_vector = N_TOTALS - 1;
  global_freq = 1;
  extscalar = 1;
  extvector = -1;
  extlist = extensive;
}

/* Read the direction; returns the number of words it has beyond one. */
int FixGranLoad::read_direction(int narg, char **arg)
{
  const std::string word = arg[3];
  if (word == "x" || word == "y" || word == "z") {
    way = {};
    way[word[0] - 'x'] = 1.0;
    return 0;
  }
  if (word != "vector")
    error->all(FLERR, "Illegal fix {}: found direction '{}', expected x, y, z or vector; {}", STYLE, word, USAGE);
  if (narg < 10) error->all(FLERR, "Illegal fix {}: {}", STYLE, USAGE);
  for (int k = 0; k < 3; k++) way[k] = utils::numeric(FLERR, arg[4 + k], false, lmp);
  const double length = std::hypot(way[0], way[1], way[2]);
  if (!(length > 0.0) || !std::isfinite(length))
    error->all(FLERR, "Illegal fix {}: a direction must not be zero, found {} {} {}", STYLE, arg[4], arg[5], arg[6]);
  for (double &part : way) part /= length;
  return 3;
}

/* Read the two columns of a table. */
void FixGranLoad::read_table(const char *file)
{
  LoadShape::Rows rows;
  const std::string fault = fmt::format("Illegal fix {}: cannot read the table {}", STYLE, file);
  for (const auto &[number, text, words] : read_rows(lmp, file, fault)) {
    std::vector<double> values;
    for (const std::string &word : words) {
      char *end;
      values.push_back(std::strtod(word.c_str(), &end));
      if (*end) values.back() = NAN;
    }
    if (values.size() != 2 || !std::isfinite(values[0]) || !std::isfinite(values[1]))
      error->all(FLERR, "Illegal fix {}: line {} of table {} must be two numbers, found '{}'", STYLE, number, file, text);
    rows.emplace_back(values[0], values[1]);
  }
  try {
    shape = LoadShape(rows);
  } catch (const std::invalid_argument &fault) {
    error->all(FLERR, "Illegal fix {}: table {} cannot be used: {}", STYLE, file, fault.what());
  }
}

void FixGranLoad::init()
{
  refuse_respa(lmp, fmt::format("Fix {}", STYLE));
  if (update->whichflag == 2) error->all(FLERR, "Fix {} does not work with minimize: its load is a function of time", STYLE);
  require_mechanical_units(lmp, fmt::format("Fix {} {}", STYLE, id));
  stepper = nullptr;
  for (auto *other : modify->get_fix_list())
    if (auto *const found = dynamic_cast<FixGranTimestep *>(other)) stepper = found;
  if (group->count(igroup) == 0) error->all(FLERR, "Fix {} {}: its group {} has no atoms", STYLE, id, group->names[igroup]);
  if (!moves) return;
  for (const auto *other : modify->get_fix_list()) {
    if (other == this || !other->time_integrate) continue;
    int shared = 0, any = 0;
    for (int i = 0; i < atom->nlocal; i++)
      if ((atom->mask[i] & groupbit) && (atom->mask[i] & other->groupbit)) shared = 1;
    MPI_Allreduce(&shared, &any, 1, MPI_INT, MPI_MAX, world);
    if (any)
      error->all(
          FLERR,
          "Fix {} {} prescribes the motion of atoms that fix {} {} integrates: remove them from the group of that fix",
          STYLE, id, other->style, other->id);
  }
}

/* Count the atoms of the group, some of which may have been lost, deleted, or removed from it. */
void FixGranLoad::count_atoms()
{
  atoms = static_cast<double>(group->count(igroup));
  if (atoms == 0.0) error->all(FLERR, "Fix {} {}: its group {} has lost all its atoms", STYLE, id, group->names[igroup]);
}

/* Lost atoms remove their motion; the work and impulse of the load on them are kept. */
void FixGranLoad::post_neighbor()
{
  const double atoms_then = atoms, mass_then = mass;
  count_atoms();
  if (!moves || atoms == atoms_then) return;
  mass = group->mass(igroup);
  keep_motion(mass_then - mass, moved / update->dt);
}

/* Add the work and impulse on a mass that has left the group. */
void FixGranLoad::keep_motion(double lost_mass, double speed)
{
  if (comm->me != 0) return;
  total[WORK] += 0.5 * lost_mass * speed * speed;
  total[IMPULSE] += lost_mass * speed;
}

/* Subtract the motion of the atoms that is not due to the load. */
void FixGranLoad::subtract_foreign_motion()
{
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    const double *const v = atom->v[i];
    double own[3] = {};
    add_along(own, velocity);
    if (std::equal(own, own + 3, v)) continue;
    const double mass_i = mass_of(atom, i);
    total[WORK] += 0.5 * mass_i * (velocity * velocity - (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    total[IMPULSE] += mass_i * (velocity - along(v));
  }
}

/* Set force or motion for the time at which the last run ended, so that no timestep is counted twice. */
void FixGranLoad::setup(int)
{
  const double now = simulated_time(*update);
  count_atoms();
  atoms_before = atoms;
  if (!moves) {
    force = shape.integral(now - 0.5 * update->dt, now + 0.5 * update->dt) / update->dt;
    apply_force(force);
    stepped = update->dt;
    if (!started) total[WORK] -= half_kick_work(update->dt);
  } else {
    const double mass_then = mass;    // 0 after a restart, which has the totals without the motion
    mass = group->mass(igroup);
    if (!started || mass_then > 0.0) subtract_foreign_motion();
    if (started && mass_then > 0.0 && std::fabs(mass_then - mass) > ROUNDING * mass) keep_motion(mass_then - mass, velocity);
    place = shape.value(now);
    velocity = shape.slope(now);
    set_velocity(velocity);
  }
  started = true;
}

/* ---------------------------------------------------------------------- a force */

void FixGranLoad::apply_force(double whole)
{
  const double share = whole / atoms;
  if (share == 0.0) return;
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) add_along(atom->f[i], share);
}

/* Work of a half kick. The half kick of velocity Verlet does the work F dt/2 times the mean of the velocities before and after
   it, which differ by f dt/2m with the total force f. With the velocity in the middle of the step instead, as below, the sum
   over timesteps lacks the difference of this term between the last step and the first. */
double FixGranLoad::half_kick_work(double dt) const
{
  const double share = force / atoms;
  double sum = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) sum += share * along(atom->f[i]) * dt * dt / (8.0 * mass_of(atom, i));
  return sum;
}

/* The timestep is about to change, at the end of a step: the next half kick compensates for what the previous one, with
   the mean of a force around the old step, gave too much or too little. */
void FixGranLoad::reset_dt()
{
  if (moves || !started || stepped == 0.0 || stepped == update->dt) return;
  const double now = simulated_time(*update), dt = update->dt, before = force;
  total[WORK] += half_kick_work(stepped);
  force = 2.0 * (shape.integral(now - 0.5 * stepped, now + 0.5 * dt) - 0.5 * stepped * before) / dt;
  apply_force(force - before);
  total[WORK] -= half_kick_work(dt);
  stepped = dt;
}

/* Add the work of a timestep, with the velocities in the middle of the step, which moved the atoms by v dt. */
void FixGranLoad::post_force(int)
{
  const double dt = update->dt, now = simulated_time(*update), before = force;
  force = shape.integral(now - 0.5 * dt, now + 0.5 * dt) / dt;
  double speeds = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) speeds += along(atom->v[i]);
  if (!std::isfinite(speeds)) require_finite_motion(lmp);
  const double moved = speeds / atoms * dt, mean = 0.5 * (before + force);
  // the remaining atoms carried only their fraction of the force before
  total[WORK] += 0.5 * (before * (atoms / atoms_before) + force) * moved;
  atoms_before = atoms;
  total[DISPLACEMENT] += moved;
  if (comm->me == 0) total[IMPULSE] += mean * dt;
  apply_force(force);
  stepped = dt;
}

/* ---------------------------------------------------------------------- a displacement */

void FixGranLoad::set_velocity(double speed)
{
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    std::fill_n(atom->v[i], 3, 0.0);
    add_along(atom->v[i], speed);
  }
}

double FixGranLoad::force_on_group() const
{
  double sum = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) sum += along(atom->f[i]);
  return sum;
}

void FixGranLoad::initial_integrate(int)
{
  if (stepper) stepper->begin_step();    // so that the clock is right
  resistance = force_on_group();         // includes the forces of all other fixes
  const double before = place;
  place = shape.value(simulated_time(*update));
  moved = place - before;
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) add_along(atom->x[i], moved);
  set_velocity(moved / update->dt);
  if (comm->me == 0) total[DISPLACEMENT] += moved;
}

void FixGranLoad::final_integrate()
{
  const double mean = 0.5 * (resistance + force_on_group());
  if (!std::isfinite(mean)) error->one(FLERR, "Fix {} {}: the force on its atoms is not finite", STYLE, id);
  total[WORK] -= mean * moved;
  total[IMPULSE] -= mean * update->dt;
  velocity = shape.slope(simulated_time(*update));
  set_velocity(velocity);
}

/* ---------------------------------------------------------------------- output and restart */

std::array<double, FixGranLoad::N_TOTALS> FixGranLoad::totals() const
{
  std::array<double, N_TOTALS> mine = {total[WORK], total[IMPULSE], total[DISPLACEMENT], 0.0}, sum;
  if (moves) mine[FORCE] = -force_on_group();
  else if (started) mine[WORK] += half_kick_work(update->dt);
  if (comm->me == 0) {
    if (!moves) mine[FORCE] = force;
    if (moves && started) {
      mine[WORK] += 0.5 * mass * velocity * velocity;
      mine[IMPULSE] += mass * velocity;
    }
  }
  MPI_Allreduce(mine.data(), sum.data(), N_TOTALS, MPI_DOUBLE, MPI_SUM, world);
  return sum;
}

double FixGranLoad::compute_vector(int n)
{
  constexpr int ORDER[] = {FORCE, IMPULSE, DISPLACEMENT};
  return totals()[ORDER[n]];
}

/* Write the totals without the present motion of the atoms, which setup() determines again. */
void FixGranLoad::write_restart(FILE *fp)
{
  std::vector<double> state(N_STATE);
  state[0] = started;
  state[1] = moves;
  MPI_Reduce(total, state.data() + 2, N_TOTALS - 1, MPI_DOUBLE, MPI_SUM, 0, world);
  if (comm->me == 0) write_state(fp, state);
}

void FixGranLoad::restart(char *buffer)
{
  const std::vector<double> state = read_state(lmp, *this, buffer, N_STATE);
  if ((state[1] != 0.0) != moves)
    error->all(FLERR, "Restart file contains fix {} {} with a {}: define it again with the arguments of the file", STYLE, id,
               moves ? "force" : "displacement");
  started = state[0] != 0.0;
  if (comm->me == 0) std::copy_n(state.data() + 2, N_TOTALS - 1, total);
}
