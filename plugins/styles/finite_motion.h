// SPDX-License-Identifier: GPL-2.0-only
/* Ends the run when positions or velocities are not finite numbers. LAMMPS's own checks miss a NaN: every comparison with
   one is false, so that such an atom never counts as moved, and the neighbour lists are not built again. */

#ifndef GRANWAVE_FINITE_MOTION_H
#define GRANWAVE_FINITE_MOTION_H

#include "lammps.h"

namespace granwave {

/* Refuse atom i (a ghost: its position alone). */
void require_finite_motion(LAMMPS_NS::LAMMPS *, int i);

/* Refuse the first of this processor's atoms that is not finite. */
void require_finite_motion(LAMMPS_NS::LAMMPS *);

}    // namespace granwave

#endif
