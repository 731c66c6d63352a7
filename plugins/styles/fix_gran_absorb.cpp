// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_absorb.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix_gran_cylinder.h"
#include "group.h"
#include "restart_state.h"
#include "update.h"

#include "../laws/exact_sum.h"

#include <cmath>
#include <cstring>
#include <string>

using namespace LAMMPS_NS;

namespace {

constexpr double SPHERE = 0.4;    // moment of inertia over m R^2, as in fix nve/sphere
constexpr const char *USAGE = "expected rate RATE, or rate RATE x|y|z FROM TO, or impedance Z x|y|z";

}    // namespace

FixGranAbsorb::FixGranAbsorb(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg < 5) error->all(FLERR, "Illegal fix {}: {} words after its name; {}", STYLE, narg - 3, USAGE);
  const std::string kind = arg[3];
  if (kind != "rate" && kind != "impedance")
    error->all(FLERR, "Illegal fix {}: '{}' is neither rate nor impedance; {}", STYLE, kind, USAGE);
  const double size = utils::numeric(FLERR, arg[4], false, lmp);
  if (!(size > 0.0) || !std::isfinite(size))
    error->all(FLERR, "Illegal fix {}: the {} must be positive, found {}", STYLE, kind, arg[4]);
  graded = kind == "rate" && narg > 5;
  (kind == "rate" ? rate : impedance) = size;
  if (narg != (kind == "impedance" ? 6 : graded ? 8 : 5))
    error->all(FLERR, "Illegal fix {}: {} words after its name; {}", STYLE, narg - 3, USAGE);
  if (narg > 5) {
    const std::string along = arg[5];
    if (along != "x" && along != "y" && along != "z")
      error->all(FLERR, "Illegal fix {}: '{}' is no direction; {}", STYLE, along, USAGE);
    axis = along[0] - 'x';
  }
  if (graded) {
    from = utils::numeric(FLERR, arg[6], false, lmp);
    to = utils::numeric(FLERR, arg[7], false, lmp);
    if (!std::isfinite(from) || !std::isfinite(to) || from == to)
      error->all(FLERR, "Illegal fix {}: the rate must rise between two places, found {} and {}", STYLE, arg[6], arg[7]);
  }

  restart_global = 1;
  scalar_flag = 1;
  global_freq = 1;
  extscalar = 1;
}

int FixGranAbsorb::setmask() { return FixConst::POST_FORCE; }

void FixGranAbsorb::init()
{
  if (std::strncmp(update->integrate_style, "respa", 5) == 0)
    error->all(FLERR, "Fix {} does not work with run_style respa", STYLE);
  if (group->count(igroup) == 0) error->all(FLERR, "Fix {} {}: its group {} has no atoms", STYLE, id, group->names[igroup]);
}

double FixGranAbsorb::rate_at(const double *x) const
{
  if (!graded) return rate;
  const double depth = (x[axis] - from) / (to - from);
  return depth <= 0.0 ? 0.0 : depth >= 1.0 ? rate : rate * depth * depth;
}

/* Velocities are those of the same instant as the forces. */

void FixGranAbsorb::setup(int) { power = apply_damping(0.0); }

/* Add the energy of the step, the trapezoid over the power at both ends. The velocities are still those of the middle of the step. */

void FixGranAbsorb::post_force(int)
{
  const double before = power;
  power = apply_damping(0.5 * update->dt);
  absorbed += 0.5 * (before + power) * update->dt;
}

/* Add forces -c v with the velocity v at the end of the step, which is the present one plus that of all forces over `until_end`;
   return the power. The sum is exact, and thus the same on any number of processors. */

double FixGranAbsorb::apply_damping(double until_end)
{
  granwave::ExactSum mine, all;
  const bool turns = rate > 0.0 && atom->omega && atom->torque && atom->radius;
  const auto *const cylinders = FixGranCylinder::find(lmp);
  const auto damp = [&](double &force, double velocity, double inertia, double c, double counted = 1.0) {
    const double at_end = (velocity + force / inertia * until_end) / (1.0 + c / inertia * until_end);
    force -= c * at_end;
    mine.add(counted * c * at_end * at_end);
  };
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    const double mass = atom->rmass ? atom->rmass[i] : atom->mass[atom->type[i]];
    if (impedance > 0.0) {
      damp(atom->f[i][axis], atom->v[i][axis], mass, impedance);
      continue;
    }
    const double here = rate_at(atom->x[i]);
    if (here == 0.0) continue;
    for (int k = 0; k < 3; k++) damp(atom->f[i][k], atom->v[i][k], mass, mass * here);
    if (!turns || atom->radius[i] == 0.0) continue;
    const double inertia = SPHERE * mass * atom->radius[i] * atom->radius[i];
    // torques on cylinders are scaled to the inertia of spheres; the energy is theirs
    const bool is_cylinder = cylinders && !cylinders->shape(atom->type[i]).is_sphere();
    const double counted = is_cylinder ? FixGranCylinder::INERTIA : 1.0;
    for (int k = 0; k < 3; k++) damp(atom->torque[i][k], atom->omega[i][k], inertia, inertia * here, counted);
  }
  MPI_Allreduce(mine.data(), all.data(), granwave::ExactSum::SIZE, MPI_INT64_T, MPI_SUM, world);
  return all.value();
}

/* ---------------------------------------------------------------------- output and restart */

double FixGranAbsorb::compute_scalar() { return absorbed; }

void FixGranAbsorb::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  granwave::write_state(fp, {absorbed});
}

void FixGranAbsorb::restart(char *buffer) { absorbed = *granwave::read_state(lmp, *this, buffer, 1); }
