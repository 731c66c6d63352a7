/* Pairs of spheres that touch in this step, some dozens at a time, and the arithmetic that is the same for all of them. It
   stands in loops without branches over plain arrays, so that a processor does several pairs at once. No LAMMPS types.

   Normal forces as if all were Hertzian: whoever knows the laws puts others in their place. Friction after tangential.h. */

#ifndef GRANWAVE_TOUCHING_H
#define GRANWAVE_TOUCHING_H

#include "tangential.h"

#include <cmath>

namespace granwave {

struct Touching {
  static constexpr int MOST = 32;

  int size = 0;
  int k[MOST], i[MOST], j[MOST];    // the pair and its spheres, as the caller counts them

  // given, by pair
  double apart[3][MOST], square[MOST];    // from j to i, and its length squared
  double radius_i[MOST], radius_j[MOST], sum_radii[MOST], effective_radius[MOST];
  double hertz[MOST];            // force = hertz overlap^(3/2)
  double shear_stiffness[MOST];  // k_t of a contact circle of radius 1: 8 G*

  // found
  double distance[MOST], overlap[MOST], force[MOST];
  double circle[MOST];                            // radius of the contact circle, squared
  double push_i[3][MOST], push_j[3][MOST];        // forces on the spheres

  // with friction: given
  double limit[MOST];                          // Coulomb's, of the tangential force; 0 where nothing rubs
  double keeps[MOST];                          // 1: Grip::KEPT, 0: RESCALED
  double velocity[3][MOST];                    // of i against j
  double omega_i[3][MOST], omega_j[3][MOST];
  double held[3][MOST];                        // tangential force on i, here and after
  double compliance[MOST], loss[MOST];         // as in Spring, here and after
  // found
  double twist_i[3][MOST], twist_j[3][MOST];    // torques on the spheres

  /* distance, overlap, force, circle: as Hertz has it */
  void measure();
  /* forces on the spheres, of the normal forces alone */
  void push();
  /* held, compliance, loss after a step of dt; nothing is held where the limit is 0 */
  void slide(double dt);
  /* forces and torques on the spheres, friction included */
  void push_and_twist();
};

}    // namespace granwave

#endif
