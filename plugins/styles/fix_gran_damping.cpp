// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_damping.h"

#include "comm.h"
#include "error.h"
#include "fix_gran_cylinder.h"
#include "group.h"
#include "modify.h"
#include "motion.h"
#include "restart_state.h"

using namespace LAMMPS_NS;
using namespace granwave;

constexpr double SPHERE = 0.4;    // moment of inertia / (m R^2), as in fix nve/sphere
constexpr const char *USAGE_OF_ABSORB = "expected rate RATE, or rate RATE x|y|z FROM TO, or impedance Z x|y|z";
constexpr const char *USAGE_OF_HOLDER = "expected x|y|z FRICTION ACCELERATION";

FixGranDamping::FixGranDamping(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  restart_global = 1;
  scalar_flag = 1;
  global_freq = 1;
  extscalar = 1;
}

void FixGranDamping::set_axis(const std::string &name, const char *usage)
{
  if (name != "x" && name != "y" && name != "z")
    error->all(FLERR, "Illegal fix {}: found direction '{}', expected x, y or z; {}", style, name, usage);
  axis = name[0] - 'x';
}

void FixGranDamping::init()
{
  refuse_respa(lmp, fmt::format("Fix {}", style));
  require_mechanical_units(lmp, fmt::format("Fix {} {}", style, id));
  if (group->count(igroup) == 0) error->all(FLERR, "Fix {} {}: its group {} has no atoms", style, id, group->names[igroup]);
}

/* Add the forces. Returns the dissipated power, as an exact sum, which is the same on any number of processors. */
double FixGranDamping::total_power(double until_end)
{
  ExactSum mine, all;
  add_forces(until_end, mine);
  MPI_Allreduce(mine.data(), all.data(), ExactSum::SIZE, MPI_LONG_LONG, MPI_SUM, world);
  return all.value();
}

/* Add the energy of the step by the trapezoidal rule, from the power at both ends. The velocities are still those of the
   middle of the step; in setup() they are those of the same instant as the forces. */
void FixGranDamping::post_force(int)
{
  const double before = power;
  power = total_power(0.5 * update->dt);
  taken += 0.5 * (before + power) * update->dt;
}

void FixGranDamping::write_restart(FILE *fp)
{
  if (comm->me == 0) write_state(fp, {taken});
}

void FixGranDamping::restart(char *buffer) { taken = read_state(lmp, *this, buffer, 1)[0]; }

/* ---------------------------------------------------------------------- absorb */

FixGranAbsorb::FixGranAbsorb(LAMMPS *lmp, int narg, char **arg) : FixGranDamping(lmp, narg, arg)
{
  if (narg < 5)
    error->all(FLERR, "Illegal fix {}: found {} arguments after the style; {}", STYLE, narg - 3, USAGE_OF_ABSORB);
  const std::string kind = arg[3];
  if (kind != "rate" && kind != "impedance")
    error->all(FLERR, "Illegal fix {}: '{}' is neither rate nor impedance; {}", STYLE, kind, USAGE_OF_ABSORB);
  graded = kind == "rate" && narg > 5;
  (kind == "rate" ? rate : impedance) = positive_number(lmp, STYLE, kind, arg[4]);
  if (narg != (kind == "impedance" ? 6 : graded ? 8 : 5))
    error->all(FLERR, "Illegal fix {}: found {} arguments after the style; {}", STYLE, narg - 3, USAGE_OF_ABSORB);
  if (narg > 5) set_axis(arg[5], USAGE_OF_ABSORB);
  if (!graded) return;
  from = utils::numeric(FLERR, arg[6], false, lmp);
  to = utils::numeric(FLERR, arg[7], false, lmp);
  if (!std::isfinite(from) || !std::isfinite(to) || from == to)
    error->all(FLERR, "Illegal fix {}: the rate must increase between two different positions, found {} and {}", STYLE,
               arg[6], arg[7]);
}

double FixGranAbsorb::rate_at(const double *x) const
{
  if (!graded) return rate;
  const double depth = (x[axis] - from) / (to - from);
  return depth <= 0.0 ? 0.0 : depth >= 1.0 ? rate : rate * depth * depth;
}

/* Add forces -c v with the velocity v at the end of the step, which is the present one plus that of all forces over `until_end`. */
void FixGranAbsorb::add_forces(double until_end, ExactSum &power)
{
  const bool turns = rate > 0.0 && atom->omega && atom->torque && atom->radius;
  const auto cylinders = FixGranCylinder::find(lmp);
  const auto damp = [&](double &force, double velocity, double inertia, double c, double counted = 1.0) {
    const double at_end = (velocity + force / inertia * until_end) / (1.0 + c / inertia * until_end);
    force -= c * at_end;
    power.add(counted * c * at_end * at_end);
  };
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    const double mass = mass_of(atom, i);
    if (impedance > 0.0) {
      damp(atom->f[i][axis], atom->v[i][axis], mass, impedance);
      continue;
    }
    const double here = rate_at(atom->x[i]);
    if (here == 0.0) continue;
    for (int k = 0; k < 3; k++) damp(atom->f[i][k], atom->v[i][k], mass, mass * here);
    if (!turns || atom->radius[i] == 0.0) continue;
    const double inertia = SPHERE * mass * atom->radius[i] * atom->radius[i];
    // torques on cylinders are scaled to the inertia of spheres; the energy is that of the cylinders
    const bool is_cylinder = cylinders && !cylinders->shape(atom->type[i]).is_sphere();
    const double counted = is_cylinder ? FixGranCylinder::INERTIA : 1.0;
    for (int k = 0; k < 3; k++) damp(atom->torque[i][k], atom->omega[i][k], inertia, inertia * here, counted);
  }
}

/* ---------------------------------------------------------------------- holder */

FixGranHolder::FixGranHolder(LAMMPS *lmp, int narg, char **arg) : FixGranDamping(lmp, narg, arg)
{
  if (narg != 6)
    error->all(FLERR, "Illegal fix {}: found {} arguments after the style; {}", STYLE, narg - 3, USAGE_OF_HOLDER);
  set_axis(arg[3], USAGE_OF_HOLDER);
  friction = positive_number(lmp, STYLE, "friction", arg[4], true);
  acceleration = positive_number(lmp, STYLE, "acceleration", arg[5]);
}

void FixGranHolder::init()
{
  FixGranDamping::init();
  // friction opposes the sum of all other forces
  bool after = false;
  for (auto *other : modify->get_fix_list()) {
    if (after && (modify->get_fix_mask(other) & FixConst::POST_FORCE))
      error->all(FLERR, "Fix {} {} must come after all fixes that apply forces, but fix {} {} follows it", STYLE, id,
                 other->style, other->id);
    after = after || other == this;
  }
}

/* Add the friction that would stop the motion at the end of the step. */
void FixGranHolder::add_forces(double until_end, ExactSum &power)
{
  const double until_stop = until_end + 0.5 * update->dt;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    const double mass = mass_of(atom, i);
    const double most = friction * mass * acceleration, v = atom->v[i][axis];
    double &force = atom->f[i][axis];
    const double wanted = -(mass * v / until_stop + force);
    const double held = std::clamp(wanted, -most, most);
    force = held == wanted ? -mass * v / until_stop : force + held;    // at rest without rounding errors
    power.add(-held * (v + force / mass * until_end));
  }
}
