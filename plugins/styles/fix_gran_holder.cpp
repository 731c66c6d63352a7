// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_holder.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "group.h"
#include "modify.h"
#include "restart_state.h"
#include "update.h"

#include "../laws/exact_sum.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

using namespace LAMMPS_NS;

namespace {

constexpr const char *USAGE = "expected x|y|z FRICTION ACCELERATION";

}    // namespace

FixGranHolder::FixGranHolder(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg != 6) error->all(FLERR, "Illegal fix {}: {} words after its name; {}", STYLE, narg - 3, USAGE);
  const std::string along = arg[3];
  if (along != "x" && along != "y" && along != "z")
    error->all(FLERR, "Illegal fix {}: '{}' is no direction; {}", STYLE, along, USAGE);
  axis = along[0] - 'x';
  friction = utils::numeric(FLERR, arg[4], false, lmp);
  acceleration = utils::numeric(FLERR, arg[5], false, lmp);
  if (!(friction >= 0.0) || !std::isfinite(friction))
    error->all(FLERR, "Illegal fix {}: the friction must be 0 or positive, found {}", STYLE, arg[4]);
  if (!(acceleration > 0.0) || !std::isfinite(acceleration))
    error->all(FLERR, "Illegal fix {}: the acceleration must be positive, found {}", STYLE, arg[5]);

  restart_global = 1;
  scalar_flag = 1;
  global_freq = 1;
  extscalar = 1;
}

int FixGranHolder::setmask() { return FixConst::POST_FORCE; }

void FixGranHolder::init()
{
  if (std::strncmp(update->integrate_style, "respa", 5) == 0)
    error->all(FLERR, "Fix {} does not work with run_style respa", STYLE);
  if (group->count(igroup) == 0) error->all(FLERR, "Fix {} {}: its group {} has no atoms", STYLE, id, group->names[igroup]);
  // friction opposes the sum of all other forces
  bool after = false;
  for (const auto *other : modify->get_fix_list()) {
    if (after && (modify->fmask[modify->find_fix(other->id)] & FixConst::POST_FORCE))
      error->all(FLERR, "Fix {} {} must come after all fixes that apply forces, but fix {} {} follows it", STYLE, id,
                 other->style, other->id);
    after = after || other == this;
  }
}

/* Friction at the start of a run, where the velocities are those of the same instant as the forces. */

void FixGranHolder::setup(int) { power = apply_friction(0.5 * update->dt, 0.0); }

/* Friction of a step, and the energy that it took since the step before: the trapezoid over its power at both ends. The
   velocities are still those of the middle of the step. */

void FixGranHolder::post_force(int)
{
  const double before = power;
  power = apply_friction(update->dt, 0.5 * update->dt);
  lost += 0.5 * (before + power) * update->dt;
}

/* Add the friction to the forces, and return the power that it takes from all atoms, exact so that it is the same on any
   number of processors.

   until_stop     time over which the velocity is to come to rest
   until_whole    time from the present velocities to those of the instant of the forces */

double FixGranHolder::apply_friction(double until_stop, double until_whole)
{
  granwave::ExactSum mine, all;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    const double mass = atom->rmass ? atom->rmass[i] : atom->mass[atom->type[i]];
    const double most = friction * mass * acceleration, v = atom->v[i][axis];
    double &force = atom->f[i][axis];
    const double wanted = -(mass * v / until_stop + force);
    const double held = std::clamp(wanted, -most, most);
    force = held == wanted ? -mass * v / until_stop : force + held;    // at rest without rounding errors
    mine.add(-held * (v + force / mass * until_whole));
  }
  MPI_Allreduce(mine.data(), all.data(), granwave::ExactSum::SIZE, MPI_INT64_T, MPI_SUM, world);
  return all.value();
}

/* ---------------------------------------------------------------------- output and restart */

double FixGranHolder::compute_scalar() { return lost; }

void FixGranHolder::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  granwave::write_state(fp, {lost});
}

void FixGranHolder::restart(char *buffer) { lost = *granwave::read_state(lmp, *this, buffer, 1); }
