// SPDX-License-Identifier: GPL-2.0-only
#include "moved_mass.h"

#include "atom.h"
#include "error.h"
#include "modify.h"

#include <algorithm>

using namespace LAMMPS_NS;

int granwave::frozen_group(LAMMPS *lmp)
{
  const auto fixes = lmp->modify->get_fix_by_style("^freeze");
  if (fixes.size() > 1)
    lmp->error->all(FLERR, "A loss of contacts needs to know what is frozen: only one fix freeze can be in use, found {}",
                    fixes.size());
  return fixes.empty() ? 0 : fixes.front()->groupbit;
}

Fix *granwave::rigid_bodies(LAMMPS *lmp)
{
  Fix *found = nullptr;
  for (auto *fix : lmp->modify->get_fix_list()) {
    if (!fix->rigid_flag) continue;
    if (found)
      lmp->error->all(FLERR,
                      "A loss of contacts needs the masses of rigid bodies: only one fix rigid can be in use, found {} "
                      "and {}",
                      found->id, fix->id);
    found = fix;
  }
  return found;
}

void granwave::set_moved_masses(LAMMPS *lmp, Fix *rigid, std::vector<double> &masses)
{
  const Atom *atom = lmp->atom;
  std::copy_n(atom->rmass, atom->nlocal, masses.begin());
  int dim;
  const auto *const body = static_cast<const int *>(rigid->extract("body", dim));
  const auto *const total = static_cast<const double *>(rigid->extract("masstotal", dim));
  if (!body || !total) return;
  for (int i = 0; i < atom->nlocal; i++)
    if (body[i] >= 0) masses[i] = total[body[i]];
}
