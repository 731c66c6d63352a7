// SPDX-License-Identifier: GPL-2.0-only
/* Checks that positions and velocities are finite. The checks of LAMMPS itself do not detect a NaN: every comparison with
   NaN is false, so that such an atom never counts as moved, and the neighbor lists are not rebuilt. */

#ifndef GRANWAVE_FINITE_MOTION_H
#define GRANWAVE_FINITE_MOTION_H

#include "lammps.h"

#include <string>

namespace granwave {

/* Stop with an error if the motion of atom i is not finite (of a ghost atom only its position is checked). */
void require_finite_motion(LAMMPS_NS::LAMMPS *, int i);

/* Stop with an error at the first atom of this processor whose motion is not finite. */
void require_finite_motion(LAMMPS_NS::LAMMPS *);

/* Return the possible causes of an overlap as large as a radius, the likely one first: before the first step the bodies were
   placed so (`placed` says it); later the load, unless their speed is a large part of the radius in one timestep. */
std::string causes_of_overlap(LAMMPS_NS::LAMMPS *, double speed, double radius, const std::string &placed);

/* Return the speed of an atom of this processor, and 0 for a ghost. */
double speed_of(LAMMPS_NS::LAMMPS *, int i);

}    // namespace granwave

#endif
