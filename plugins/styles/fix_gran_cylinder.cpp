// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_cylinder.h"

#include "comm.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "motion.h"
#include "restart_state.h"

#include <cstring>

using namespace LAMMPS_NS;
using namespace granwave;

constexpr int WORDS = 5;    // of each type
constexpr const char *USAGE =
    "expected TYPE LENGTH AX AY AZ, once for each type of cylinders, and optionally line half-space|plane-strain";
constexpr double ROUNDING = 1e-9;

FixGranCylinder::FixGranCylinder(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), cylinders(std::make_shared<Cylinders>(atom->ntypes))
{
  if (narg > 4 && std::strcmp(arg[narg - 2], "line") == 0) {
    const std::string kind = arg[narg - 1];
    if (kind != "half-space" && kind != "plane-strain")
      error->all(FLERR, "Illegal fix {}: expected line half-space or plane-strain, found {}", STYLE, kind);
    cylinders->plane_strain = kind == "plane-strain";
    narg -= 2;
  }
  if (narg < 3 + WORDS || (narg - 3) % WORDS != 0) error->all(FLERR, "Illegal fix {}: {}", STYLE, USAGE);
  for (int n = 3; n < narg; n += WORDS) {
    const int type = utils::inumeric(FLERR, arg[n], false, lmp);
    if (type < 1 || type > atom->ntypes)
      error->all(FLERR, "Illegal fix {}: expected a type from 1 to {}, found {}", STYLE, atom->ntypes, arg[n]);
    Cylinder &cylinder = cylinders->shapes[type];
    if (!cylinder.is_sphere()) error->all(FLERR, "Illegal fix {}: found type {} twice", STYLE, type);
    cylinder.length = positive_number(lmp, STYLE, "length of a cylinder", arg[n + 1]);
    double square = 0.0;
    for (int d = 0; d < 3; d++) {
      cylinder.axis[d] = utils::numeric(FLERR, arg[n + 2 + d], false, lmp);
      square += cylinder.axis[d] * cylinder.axis[d];
    }
    if (!(square > 0.0 && std::isfinite(square)))
      error->all(FLERR, "Illegal fix {}: the axis of a cylinder must be a direction, found {} {} {}", STYLE, arg[n + 2],
                 arg[n + 3], arg[n + 4]);
    if (square != 1.0)
      for (double &component : cylinder.axis) component /= std::sqrt(square);
  }
  for (const auto *other : modify->get_fix_list())
    if (std::strcmp(other->style, STYLE) == 0)
      error->all(FLERR, "Illegal fix {}: fix {} already exists; use only one", STYLE, other->id);
  restart_global = 1;
  scalar_flag = 1;
  global_freq = 1;
  extscalar = 1;
}

std::shared_ptr<const Cylinders> FixGranCylinder::find(LAMMPS *lmp)
{
  for (const auto *fix : lmp->modify->get_fix_list())
    if (const auto *const found = dynamic_cast<const FixGranCylinder *>(fix)) return found->cylinders;
  return nullptr;
}

void FixGranCylinder::init()
{
  if (!atom->radius_flag) error->all(FLERR, "Fix {} requires atom attribute radius (atom_style sphere)", STYLE);
  bool after = false;
  for (auto *other : modify->get_fix_list()) {
    int dim;    // only walls have a coefficient of friction
    const auto *const friction = static_cast<const double *>(other->extract("friction", dim));
    if (after && friction && *friction > 0.0)
      error->all(FLERR,
                 "Fix {} {} must come after all walls with friction, whose torques it projects, but fix {} {} follows it",
                 STYLE, id, other->style, other->id);
    after = after || other == this;
  }
}

void FixGranCylinder::setup(int)
{
  if (!atom->omega_flag) return;
  for (int i = 0; i < atom->nlocal; i++) {
    const Cylinder &cylinder = cylinders->shape(atom->type[i]);
    if (cylinder.is_sphere()) continue;
    const double *const omega = atom->omega[i], *const axis = cylinder.axis;
    const double along = omega[0] * axis[0] + omega[1] * axis[1] + omega[2] * axis[2];
    const double square = omega[0] * omega[0] + omega[1] * omega[1] + omega[2] * omega[2];
    if (square - along * along > ROUNDING * square)
      error->one(
          FLERR,
          "Fix {} {}: cylinder {} has the angular velocity ({:.6g}, {:.6g}, {:.6g}), but can rotate only about its axis",
          STYLE, id, atom->tag[i], omega[0], omega[1], omega[2]);
  }
  post_force(0);
}

/* Torque that gives a sphere of the same mass and radius the rotation of the cylinder. */
void FixGranCylinder::post_force(int)
{
  if (!atom->torque_flag) return;
  for (int i = 0; i < atom->nlocal; i++) {
    const Cylinder &cylinder = cylinders->shape(atom->type[i]);
    if (cylinder.is_sphere()) continue;
    double *const torque = atom->torque[i];
    const double *const axis = cylinder.axis;
    const double along = torque[0] * axis[0] + torque[1] * axis[1] + torque[2] * axis[2];
    for (int d = 0; d < 3; d++) torque[d] = along / INERTIA * axis[d];
  }
}

/* Rotational energy of the cylinders minus the energy of spheres with the same masses and radii. */
double FixGranCylinder::compute_scalar()
{
  if (!atom->omega_flag) return 0.0;
  double mine = 0.0, all = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    if (cylinders->shape(atom->type[i]).is_sphere()) continue;
    const double *const omega = atom->omega[i];
    mine += 0.5 * force->mvv2e * 0.4 * (INERTIA - 1.0) * atom->rmass[i] * atom->radius[i] * atom->radius[i] *
            (omega[0] * omega[0] + omega[1] * omega[1] + omega[2] * omega[2]);
  }
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, world);
  return all;
}

/* ---------------------------------------------------------------------- restart: the shapes must be the same */

void FixGranCylinder::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  const auto &shapes = cylinders->shapes;
  std::vector<double> state = {double(shapes.size())};
  for (const Cylinder &one : shapes) state.insert(state.end(), {one.length, one.axis[0], one.axis[1], one.axis[2]});
  write_state(fp, state);
}

void FixGranCylinder::restart(char *buffer)
{
  const auto &shapes = cylinders->shapes;
  const std::vector<double> state = read_state(lmp, *this, buffer, 1 + 4 * shapes.size(), "other cylinders");
  const double *value = state.data();
  bool same = *value++ == static_cast<double>(shapes.size());
  for (std::size_t type = 0; same && type < shapes.size(); type++, value += 4)
    same = shapes[type] == Cylinder{value[0], {value[1], value[2], value[3]}};
  if (!same)
    error->all(FLERR, "Restart file contains fix {} {} with other cylinders: define it again with the arguments of the file",
               STYLE, id);
}
