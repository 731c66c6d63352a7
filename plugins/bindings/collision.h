// SPDX-License-Identifier: GPL-2.0-only
/* Head-on collision of two bodies with a contact law and viscous damping. */

#ifndef GRANWAVE_BINDINGS_COLLISION_H
#define GRANWAVE_BINDINGS_COLLISION_H

#include "../laws/law_arguments.h"

namespace granwave::bindings {

/* Head-on collision of two bodies with a contact law and a viscous loss, by the classical Runge-Kutta method; of viscoelastic
   bodies by velocity Verlet. */
struct Collision {
  // speed of separation / speed of approach, 0 without separation, NaN if the bodies are not stopped
  double restitution;
  double duration, peak_force, peak_overlap;
};

/* Collide bodies of an effective mass with a speed of approach. `steps` is about the number of steps in the collision. */
Collision collide(const ScaledLaw &law, const ViscousLoss &loss, double mass, double speed, int steps);

}    // namespace granwave::bindings

#endif
