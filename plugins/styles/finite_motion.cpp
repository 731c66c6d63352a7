// SPDX-License-Identifier: GPL-2.0-only
#include "finite_motion.h"

#include "atom.h"
#include "error.h"
#include "fmt/format.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

using namespace LAMMPS_NS;

namespace {

// 0 times a finite number is 0; 0 times infinity or NaN is NaN
bool finite(const double *vector) { return 0.0 * vector[0] + 0.0 * vector[1] + 0.0 * vector[2] == 0.0; }

std::string printed(double value) { return std::isnan(value) ? "nan" : fmt::format("{:.6g}", value); }

void require_finite(LAMMPS *lmp, int i, const double *vector, const char *name)
{
  if (finite(vector)) return;
  lmp->error->one(FLERR,
                  "The {} of sphere {} is not finite ({} {} {}): it was set so, the force on the sphere is not finite, or "
                  "the timestep is far too large",
                  name, lmp->atom->tag[i], printed(vector[0]), printed(vector[1]), printed(vector[2]));
}

}    // namespace

void granwave::require_finite_motion(LAMMPS *lmp, int i)
{
  const Atom *atom = lmp->atom;
  require_finite(lmp, i, atom->x[i], "position");
  if (i >= atom->nlocal) return;
  require_finite(lmp, i, atom->v[i], "velocity");
  if (atom->omega_flag) require_finite(lmp, i, atom->omega[i], "angular velocity");
}

void granwave::require_finite_motion(LAMMPS *lmp)
{
  for (int i = 0; i < lmp->atom->nlocal; i++) require_finite_motion(lmp, i);
}

std::string granwave::causes_of_overlap(LAMMPS *lmp, double speed, double radius, const std::string &placed)
{
  constexpr double LARGE = 0.02;    // of the radius: a contact would be loaded in less than 50 steps
  std::vector<std::string> causes = {"the load is too strong or the impact too fast for these materials", placed,
                                     "the timestep is far too large"};
  const int likely = lmp->update->setupflag ? 1 : speed * lmp->update->dt > LARGE * radius ? 2 : 0;
  std::rotate(causes.begin(), causes.begin() + likely, causes.begin() + likely + 1);    // to the front
  return fmt::format("{}, or {}, or {}", causes[0], causes[1], causes[2]);
}

double granwave::speed_of(LAMMPS *lmp, int i)
{
  if (i >= lmp->atom->nlocal) return 0.0;
  const double *const v = lmp->atom->v[i];
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}
