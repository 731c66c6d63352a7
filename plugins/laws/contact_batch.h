// SPDX-License-Identifier: GPL-2.0-only
/* Batch of touching pairs as plain arrays (structure of arrays): arithmetic common to all pairs is done in loops without
   branches, which the compiler can vectorize. No LAMMPS types.

   Normal forces are Hertzian; the caller overwrites those of contacts that have yielded. Friction as in tangential.h. */

#ifndef GRANWAVE_CONTACT_BATCH_H
#define GRANWAVE_CONTACT_BATCH_H

#include "tangential.h"

#include <cmath>

namespace granwave {

struct ContactBatch {
  static constexpr int CAPACITY = 32;

  int size = 0;
  int k[CAPACITY], i[CAPACITY], j[CAPACITY];    // indices of the pair and its spheres, as set by the caller

  // input, by pair
  double del[3][CAPACITY], rsq[CAPACITY];    // from j to i, and its length squared
  double radius_i[CAPACITY], radius_j[CAPACITY], radsum[CAPACITY], effective_radius[CAPACITY];
  double hertz[CAPACITY];              // force = hertz overlap^(3/2)
  double shear_stiffness[CAPACITY];    // k_t of a contact circle of radius 1: 8 G*

  // output
  double r[CAPACITY], overlap[CAPACITY], force[CAPACITY];    // distance, overlap, normal force
  double circle[CAPACITY];                                   // radius of the contact circle, squared
  double force_i[3][CAPACITY], force_j[3][CAPACITY];         // on the spheres

  // friction, input
  double limit[CAPACITY];          // Coulomb's limit of the tangential force; 0 without friction
  double keeps[CAPACITY];          // 1: TangentialModel::MINDLIN, 0: MINDLIN_RESCALE
  double velocity[3][CAPACITY];    // of i relative to j
  double omega_i[3][CAPACITY], omega_j[3][CAPACITY];
  double tangential[3][CAPACITY];                 // tangential force on i, before and after
  double compliance[CAPACITY], loss[CAPACITY];    // as in TangentialSpring, before and after
  // friction, output
  double torque_i[3][CAPACITY], torque_j[3][CAPACITY];    // on the spheres

  /* Compute distance, overlap, Hertzian force and contact circle. */
  void compute_overlap();
  /* Compute the forces on the spheres from the normal forces only. */
  void compute_normal();
  /* Advance tangential force, compliance and loss by a timestep dt; the force is 0 if the limit is 0. */
  void compute_tangential(double dt);
  /* Compute forces and torques on the spheres, including friction. */
  void compute_forces_and_torques();
};

}    // namespace granwave

#endif
