// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_timestep.h"

#include "../kernels/touching_pairs.h"

#include "comm.h"
#include "compute.h"
#include "error.h"
#include "fix_wall_gran_hysteretic.h"
#include "force.h"
#include "info.h"
#include "input.h"
#include "modify.h"
#include "motion.h"
#include "output.h"
#include "pair.h"
#include "restart_state.h"
#include "timer.h"
#include "variable.h"

#include <array>

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

constexpr std::int64_t MOST_TICKS = std::int64_t(1) << 20;
constexpr double LEAST_TOLERANCE = 1e-12, MOST_TOLERANCE = 1e-3;
constexpr std::int64_t STEPS_BETWEEN_ENERGIES = 16;

constexpr double AIM = 0.85;                          // fraction of the tolerance that the choice uses
constexpr double SHARE_OF_TOLERANCE = 1.0 / 65536;    // resolution of a measured error / tolerance
constexpr const char *USAGE = "expected N TOLERANCE ENERGY, optionally followed by first M, until T, balance v_NAME K";

// Fixed-point sums are bitwise identical in any order. A term is at most 2 energies, in units of 2^-50 of one.
constexpr double UNITS = 1125899906842624.0;               // 2^50
constexpr double MAGIC = 6755399441055744.0;               // 1.5 2^52: adding it leaves an integer in the mantissa
constexpr std::int64_t MAGIC_BITS = 0x4338000000000000;    // its bits

std::int64_t units_of(double term)
{
  const double bounded = term > 2.0 ? 2.0 : term < -2.0 ? -2.0 : term;    // a term that is not a number stays not a number
  const double shifted = bounded * UNITS + MAGIC;
  std::int64_t bits;
  std::memcpy(&bits, &shifted, sizeof(bits));
  return bits - MAGIC_BITS;
}

/* Fixes of LAMMPS that multiply the step counter by the timestep, or an interval by it. */
constexpr std::array<const char *, 4> MULTIPLY_STEPS = {"^controller", "^deform", "^move", "^pour"};

/* Fixes of LAMMPS that wait for certain steps, and with Nevery = 1 for each of them. */
constexpr std::array<const char *, 3> WAIT_FOR_STEPS = {"^ave/", "^print", "^vector"};

/* Functions of variables that multiply the step counter by the timestep. */
constexpr std::array<const char *, 3> FUNCTIONS_OF_STEPS = {"vdisplace(", "swiggle(", "cwiggle("};

template <std::size_t N> bool matches(const char *style, const std::array<const char *, N> &patterns)
{
  return std::any_of(patterns.begin(), patterns.end(), [style](const char *p) { return utils::strmatch(style, p); });
}

bool power_of_two(std::int64_t n) { return n > 0 && (n & (n - 1)) == 0; }

/* Rounded to 20 bits: an energy whose last bits depend on the number of processors must not change the choice. */
double rounded(double value)
{
  int exponent;
  const double mantissa = std::frexp(value, &exponent);
  return std::ldexp(std::round(std::ldexp(mantissa, 20)), exponent - 20);
}

}    // namespace

FixGranTimestep::FixGranTimestep(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), controller(1, 1)
{
  if (narg < 6) error->all(FLERR, "Illegal fix {}: {}", STYLE, USAGE);
  longest = utils::bnumeric(FLERR, arg[3], false, lmp);
  if (!power_of_two(longest) || longest > MOST_TICKS)
    error->all(FLERR, "Illegal fix {}: N must be a power of two up to {}, found {}", STYLE, MOST_TICKS, arg[3]);
  tolerance = utils::numeric(FLERR, arg[4], false, lmp);
  if (!(tolerance >= LEAST_TOLERANCE && tolerance <= MOST_TOLERANCE))
    error->all(FLERR, "Illegal fix {}: the tolerance must be between {:g} and {:g}, found {}", STYLE, LEAST_TOLERANCE,
               MOST_TOLERANCE, arg[4]);
  if (utils::strmatch(arg[5], "^v_")) {
    energy_name = arg[5] + 2;
  } else {
    energy = utils::numeric(FLERR, arg[5], false, lmp);
    if (!(energy > 0.0) || !std::isfinite(energy))
      error->all(FLERR, "Illegal fix {}: the energy must be positive, or v_NAME, found {}", STYLE, arg[5]);
  }
  for (int n = 6; n < narg;) {
    const std::string word = arg[n];
    if (word == "first" && n + 1 < narg) {
      first = taken = utils::bnumeric(FLERR, arg[n + 1], false, lmp);
      if (!power_of_two(first) || first > longest)
        error->all(FLERR, "Illegal fix {}: first must be a power of two up to N, {}, found {}", STYLE, longest, arg[n + 1]);
      n += 2;
    } else if (word == "until" && n + 1 < narg) {
      until = utils::numeric(FLERR, arg[n + 1], false, lmp);
      n += 2;
    } else if (word == "balance" && n + 2 < narg && utils::strmatch(arg[n + 1], "^v_")) {
      balance_name = arg[n + 1] + 2;
      balance_every = utils::bnumeric(FLERR, arg[n + 2], false, lmp);
      if (balance_every < 1) error->all(FLERR, "Illegal fix {}: balance every {}, expected 1 or more", STYLE, arg[n + 2]);
      n += 3;
    } else {
      error->all(FLERR, "Illegal fix {}: found '{}'; {}", STYLE, word, USAGE);
    }
  }
  for (const auto *other : modify->get_fix_list())
    if (std::strcmp(other->style, STYLE) == 0)
      error->all(FLERR, "Fix {} {}: fix {} already exists; use only one", STYLE, id, other->id);
  controller = StepController(taken, longest);
  tick = update->dt;
  origin = update->atime - static_cast<double>(update->atimestep) * tick;
  nevery = 1;
  restart_global = 1;
  vector_flag = 1;
  size_vector = 5;
  global_freq = 1;
  extvector = 0;
  time_depend = 1;
}

FixGranTimestep::~FixGranTimestep()
{
  if (!update || update->dt == tick) return;
  update->dt = tick;
  for (auto *other : modify->get_fix_list())
    if (other != this) other->reset_dt();
}

void FixGranTimestep::init()
{
  if (std::strcmp(update->integrate_style, "verlet") != 0)
    error->all(FLERR, "Fix {} works with run_style verlet, found {}", STYLE, update->integrate_style);
  if (update->whichflag == 2) error->all(FLERR, "Fix {} does not work with minimize", STYLE);
  const bool started = n_steps > 0 || update->dt != tick;
  if (started && update->dt != static_cast<double>(taken) * tick)
    error->all(FLERR, "Fix {} {}: the timestep was changed to {:g}; unfix it first", STYLE, id, update->dt);
  require_mechanical_units(lmp, fmt::format("Fix {} {}", STYLE, id));
  bool later = false;
  rotates = 0;
  others.clear();
  rebuilders.clear();
  walls.clear();
  n_atoms = atom->natoms;
  refuse_fixes_that_count_steps();
  refuse_variables_that_count_steps();
  cylinders = FixGranCylinder::find(lmp);
  integrated = integrated_groups(lmp);
  for (const auto *other : modify->get_fix_list()) {
    if (other == this) {
      later = true;
      continue;
    }
    if (const auto *const wall = dynamic_cast<const FixWallGranHysteretic *>(other)) walls.push_back(wall);
    if (utils::strmatch(other->style, "nve/sphere")) rotates |= other->groupbit;
    if (std::strcmp(other->style, "dt/reset") == 0)
      error->all(FLERR, "Fix {} {}: fix dt/reset also changes the timestep; unfix it", STYLE, id);
    if (other->force_reneighbor) rebuilders.push_back(other);
    if (other->nevery > 1) others.push_back(other);
    const bool ends_steps = modify->get_fix_mask(const_cast<Fix *>(other)) & FixConst::END_OF_STEP;
    if (later && ends_steps && other->nevery > 0)
      error->all(FLERR, "Fix {} {} must come after all fixes that act at the end of a step, but fix {} follows it", STYLE,
                 id, other->id);
  }
  for (const auto &name : {energy_name, balance_name}) {
    if (name.empty()) continue;
    const int found = input->variable->find(name.c_str());
    if (found < 0) error->all(FLERR, "Fix {} {}: there is no variable {}", STYLE, id, name);
    if (!input->variable->equalstyle(found))
      error->all(FLERR, "Fix {} {}: variable {} is not of style equal", STYLE, id, name);
  }
  reached = update->ntimestep;
  take(taken);
  if (n_steps == 0) report();
}

/* Stop with an error if another fix would count ticks as steps. */
void FixGranTimestep::refuse_fixes_that_count_steps() const
{
  if (longest == 1) return;    // a step is a tick
  for (const auto *other : modify->get_fix_list()) {
    if (matches(other->style, MULTIPLY_STEPS))
      error->all(FLERR,
                 "Fix {} {}: fix {} {} multiplies the number of steps by the timestep, and a step has several ticks: "
                 "unfix one of the two",
                 STYLE, id, other->style, other->id);
    if (other->nevery == 1 && matches(other->style, WAIT_FOR_STEPS))
      error->all(
          FLERR,
          "Fix {} {}: fix {} {} waits for every tick, and a step has several: set an interval, preferably a multiple of {}",
          STYLE, id, other->style, other->id, longest);
    const bool wall_of_lammps =
        utils::strmatch(other->style, "^wall/gran") && !dynamic_cast<const FixWallGranHysteretic *>(other);
    if (wall_of_lammps && comm->me == 0)
      error->warning(FLERR, "Fix {} {}: a wall of fix {} {} must not wiggle, because fix wall/gran counts ticks as steps",
                     STYLE, id, other->style, other->id);
  }
}

/* Stop with an error if a variable has a function that counts ticks as steps. */
void FixGranTimestep::refuse_variables_that_count_steps() const
{
  if (longest == 1) return;
  Info info(lmp);
  Variable *const variables = input->variable;
  for (int n = 0; n < variables->nvar; n++) {
    if (!variables->equalstyle(n) && !variables->atomstyle(n) && !variables->vectorstyle(n)) continue;
    const std::string text = info.get_variable_info(n);
    for (const std::string function : FUNCTIONS_OF_STEPS)
      if (text.find(function) != std::string::npos)
        error->all(FLERR,
                   "Fix {} {}: variable {} has {}...), which multiplies the number of steps by the timestep, and a step "
                   "has several ticks: write it with the keyword time",
                   STYLE, id, variables->names[n], function);
  }
}

/* Set the timestep of the following steps. */
void FixGranTimestep::take(std::int64_t ticks)
{
  const double dt = static_cast<double>(ticks) * tick;
  update->atime = origin + static_cast<double>(reached) * tick;
  update->atimestep = reached;
  if (ticks == taken && dt == update->dt) return;
  taken = ticks;
  update->dt = dt;
  update->dt_default = 0;
  if (force->pair) force->pair->reset_dt();
  for (auto *other : modify->get_fix_list()) other->reset_dt();
}

void FixGranTimestep::setup(int)
{
  if (is_rerun(*update)) error->all(FLERR, "Fix {} {} does not work with rerun", STYLE, id);
  reached = update->ntimestep;
  pending = true;
  if (n_steps == 0 || energy == 0.0) {    // otherwise as if the two runs were one
    read_energy();
    bound_step();
  }
  last = sums();
}

/* Present value of a variable, which is needed again at the step `next`. */
double FixGranTimestep::value_of(const std::string &variable, bigint next) const
{
  modify->clearstep_compute();
  const double found = input->variable->compute_equal(input->variable->find(variable.c_str()));
  modify->addstep_compute(next);
  return found;
}

/* Energy that errors are relative to. */
void FixGranTimestep::read_energy()
{
  if (energy_name.empty()) return;
  const double found = value_of(energy_name, update->ntimestep + 1);
  energy = std::isfinite(found) ? rounded(std::fabs(found)) : 0.0;
}

/* Power of the forces times a tick, and force^2/mass times tick^2. Blocks of spheres without force have none. */
FixGranTimestep::Sums FixGranTimestep::sums() const
{
  if (energy == 0.0) return {};
  const double *const *const v = atom->v, *const *const f = atom->f;
  const double of_power = tick / energy, of_force = tick * tick / energy;
  std::int64_t mine[2] = {}, all[2];
  const auto add = [&](int i) {
    if (!(atom->mask[i] & groupbit)) return;
    const double mass = mass_of(atom, i);
    double p = f[i][0] * v[i][0] + f[i][1] * v[i][1] + f[i][2] * v[i][2];
    double q = (f[i][0] * f[i][0] + f[i][1] * f[i][1] + f[i][2] * f[i][2]) / mass;
    if (rotates && atom->radius[i] > 0.0) {
      const double *const torque = atom->torque[i], *const omega = atom->omega[i];
      const double inertia = 0.4 * mass * atom->radius[i] * atom->radius[i];
      double turning = torque[0] * omega[0] + torque[1] * omega[1] + torque[2] * omega[2];
      double squared = (torque[0] * torque[0] + torque[1] * torque[1] + torque[2] * torque[2]) / inertia;
      if (cylinders && !cylinders->shape(atom->type[i]).is_sphere()) {    // torque of a sphere with the same rotation
        turning *= FixGranCylinder::INERTIA;
        squared *= FixGranCylinder::INERTIA;
      }
      p += turning;
      if (atom->mask[i] & rotates) q += squared;
    }
    mine[0] += units_of(p * of_power);
    if (atom->mask[i] & integrated) mine[1] += units_of(q * of_force);    // others are not accelerated
  };
  for (int begin = 0; begin < atom->nlocal; begin += RestingBlocks::SIZE) {
    const int n = std::min(RestingBlocks::SIZE, atom->nlocal - begin);
    if (all_zero(f[begin], 3 * n) && !(rotates && !all_zero(atom->torque[begin], 3 * n))) continue;
    for (int i = begin; i < begin + n; i++) add(i);
  }
  MPI_Allreduce(mine, all, 2, MPI_LONG_LONG, MPI_SUM, world);
  double power = 0.0, force_squared_over_mass = 0.0;    // of supports, the same on all processors
  for (const auto *wall : walls) wall->add_power(power, force_squared_over_mass);
  return {static_cast<double>(all[0]) / UNITS * energy + power * tick,
          static_cast<double>(all[1]) / UNITS * energy + force_squared_over_mass * tick * tick};
}

/* Limit the step by a collision that may occur at any time: a sphere with the fraction e of the energy then makes an
   error of e (step/first)^2 of that in the collision for which the first step was chosen. */
void FixGranTimestep::bound_step()
{
  double mine = 0.0, most = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    const double *const v = atom->v[i];
    const double mass = mass_of(atom, i);
    mine = std::max(mine, 0.5 * mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
  }
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, world);
  const double of_first = most > 0.0 ? std::sqrt(energy / most) : static_cast<double>(longest);
  bound = static_cast<double>(first) * std::max(1.0, of_first);
}

/* First step at which something is due after the present one. */
bigint FixGranTimestep::next_due() const
{
  bigint due = reached < update->laststep ? update->laststep : MAXBIGINT;
  if (output->next > reached) due = std::min(due, output->next);
  if (balance_every > 0) due = std::min(due, (reached / balance_every + 1) * balance_every);
  for (const auto *other : others) due = std::min(due, (reached / other->nevery + 1) * other->nevery);
  for (const auto *other : rebuilders)
    if (other->next_reneighbor > reached) due = std::min(due, other->next_reneighbor);
  return due;
}

/* True if a compute needs energies or a virial at a step, which pair and bond styles sum only on request. */
bool FixGranTimestep::tallied(bigint step) const
{
  for (auto *compute : modify->get_compute_list())
    if ((compute->peflag || compute->peatomflag || compute->pressflag || compute->pressatomflag) && compute->matchstep(step))
      return true;
  return false;
}

/* True if the first step of a run may have this number of ticks. The run has asked its computes already whether they need
   energies or a virial, for the step after one tick. */
bool FixGranTimestep::fits(std::int64_t ticks, bigint due) const
{
  return reached % ticks == 0 && reached + ticks <= due && !tallied(reached + ticks);
}

void FixGranTimestep::begin_step()
{
  if (!pending) return;
  pending = false;
  const bigint due = next_due();
  std::int64_t next = taken;
  while (next > 1 && !fits(next, due)) next /= 2;
  controller.take(next, s);
  take(next);
  set_clock();
  update->ntimestep++;
}

/* The run is about to add 1 to the counter: add the other ticks of the step. The clock is that of its end. */
void FixGranTimestep::set_clock()
{
  update->ntimestep = reached + taken - 1;
  update->atimestep = reached + taken;
  update->atime = origin + static_cast<double>(reached + taken) * tick;
}

void FixGranTimestep::initial_integrate(int)
{
  begin_step();
  n_steps++;
  shortest_taken = shortest_taken == 0 ? taken : std::min(shortest_taken, taken);
  longest_taken = std::max(longest_taken, taken);
  report();
}

void FixGranTimestep::report()
{
  reported[0] = static_cast<double>(taken) * tick;
  reported[1] = energy > 0.0 ? controller.error(s) / energy : 0.0;
  reported[2] = static_cast<double>(n_steps);
  reported[3] = static_cast<double>(shortest_taken) * tick;
  reported[4] = static_cast<double>(longest_taken) * tick;
}

void FixGranTimestep::end_of_step()
{
  reached = update->ntimestep;
  if (n_steps % STEPS_BETWEEN_ENERGIES == 0 || energy == 0.0) {
    read_energy();
    bound_step();
  }
  const Sums now = sums();
  const bool other_atoms = atom->natoms != n_atoms;
  if (other_atoms) last = now;
  const double before = s;
  s = (now.q + last.q) / 48.0 - (now.p - last.p) / (12.0 * static_cast<double>(taken));
  if (other_atoms) {
    controller.shift(s - before);
    bound_step();
  }
  n_atoms = atom->natoms;
  last = now;
  if (balance_every > 0 && reached % balance_every == 0 && energy > 0.0) {
    const double measured = value_of(balance_name, reached + balance_every);
    // the last bits of the sums in it depend on the number of processors
    const double unit = SHARE_OF_TOLERANCE * tolerance * energy;
    if (std::isfinite(measured)) controller.correct(s, std::round(measured / unit) * unit);
  }
  const bool held = origin + static_cast<double>(reached) * tick < until;
  const double most = held ? std::min(bound, static_cast<double>(first)) : bound;
  std::int64_t next = controller.choose(s, AIM * tolerance * energy, most, reached, next_due());
  // output that is due now is written here, as the run would do immediately afterwards, before the counter is increased
  if (reached == output->next) {
    const double dt = update->dt;
    update->dt = tick;    // dumps at intervals of time count steps
    timer->stamp();
    output->write(reached);
    timer->stamp(Timer::OUTPUT);
    update->dt = dt;
    // only now the next output is known
    const bigint due = next_due();
    while (next > 1 && reached + next > due) next /= 2;
    controller.take(next, s);
  }
  take(next);
  pending = reached >= update->laststep;
  if (pending) timer->force_timeout();
  else set_clock();
}

void FixGranTimestep::post_run()
{
  update->ntimestep = update->atimestep = reached;
  update->atime = origin + static_cast<double>(reached) * tick;
  pending = true;
  if (reached >= update->laststep) timer->reset_timeout();
}

/* ---------------------------------------------------------------------- restart */

void FixGranTimestep::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  std::vector<double> state = {tick,
                               origin,
                               energy,
                               bound,
                               s,
                               double(n_steps),
                               double(shortest_taken),
                               double(longest_taken),
                               std::round(reported[0] / tick),
                               reported[1]};
  const std::vector<double> of_choice = controller.state();
  state.insert(state.end(), of_choice.begin(), of_choice.end());
  write_state(fp, state);
}

void FixGranTimestep::restart(char *buffer)
{
  const std::vector<double> stored = read_state(lmp, *this, buffer, 10 + controller.state().size());
  const double *state = stored.data();
  if (state[0] != tick)
    error->all(FLERR, "Restart file contains fix {} {} with ticks of {:.17g}, found a timestep of {:.17g}", STYLE, id,
               state[0], tick);
  state++;
  for (double *number : {&origin, &energy, &bound, &s}) *number = *state++;
  for (std::int64_t *number : {&n_steps, &shortest_taken, &longest_taken, &taken})
    *number = static_cast<std::int64_t>(*state++);
  report();
  reported[1] = *state++;
  taken = controller.restore(state);
  update->dt = static_cast<double>(taken) * tick;
}
