// SPDX-License-Identifier: GPL-2.0-only
/* Masses that spheres move with, for dashpots: frozen spheres do not move, and those of rigid bodies move with the mass of the body,
   as in the granular styles of LAMMPS. */

#ifndef GRANWAVE_MOVED_MASS_H
#define GRANWAVE_MOVED_MASS_H

#include "fix.h"

#include <vector>

namespace granwave {

/* Bit of the group of fix freeze; 0 if there is none. */
int frozen_group(LAMMPS_NS::LAMMPS *);

/* The fix of rigid bodies; null if there is none. */
LAMMPS_NS::Fix *rigid_bodies(LAMMPS_NS::LAMMPS *);

/* Set the masses that the owned spheres move with; the vector has at least as many elements. */
void set_moved_masses(LAMMPS_NS::LAMMPS *, LAMMPS_NS::Fix *rigid, std::vector<double> &masses);

}    // namespace granwave

#endif
