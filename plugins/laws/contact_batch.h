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
  static constexpr int CAPACITY = 64;

  int size = 0;
  int k[CAPACITY], i[CAPACITY], j[CAPACITY];    // indices of the pair and its spheres, as set by the caller

  // input, by pair
  double del[3][CAPACITY];    // components of the vector from j to i
  double rsq[CAPACITY];       // its length squared
  double radius_i[CAPACITY], radius_j[CAPACITY], radsum[CAPACITY], effective_radius[CAPACITY];
  double hertz[CAPACITY];              // force = hertz overlap^(3/2)
  double shear_stiffness[CAPACITY];    // k_t of a contact circle of radius 1: 8 G*
  double largest_overlap[CAPACITY];    // beyond it the overlap is an error
  double elastic_limit[CAPACITY];      // overlap up to which a contact is Hertzian

  // output
  double r[CAPACITY], overlap[CAPACITY], force[CAPACITY];    // distance, overlap, normal force
  double circle[CAPACITY];                                   // radius of the contact circle, squared
  double pair_force[CAPACITY];                               // normal force over distance

  // friction, input
  double limit[CAPACITY];          // Coulomb's limit of the tangential force; 0 without friction
  double keeps[CAPACITY];          // 1: TangentialModel::MINDLIN, 0: MINDLIN_RESCALE
  double velocity[3][CAPACITY];    // of i relative to j
  double omega_i[3][CAPACITY], omega_j[3][CAPACITY];
  double tangential[3][CAPACITY];                 // tangential force on i, before and after
  double compliance[CAPACITY], loss[CAPACITY];    // as in TangentialSpring, before and after
  // friction, output
  double force_i[3][CAPACITY];                                         // on sphere i, the opposite on j
  double torque[3][CAPACITY], lever_i[CAPACITY], lever_j[CAPACITY];    // torque on either sphere per unit of its lever arm

  /* Compute distance, overlap, Hertzian force and contact circle. Returns true if an overlap is too large or not a number. */
  bool compute_overlap();
  /* Compute normal force over distance. */
  void compute_normal();
  /* Compute forces and torques on the spheres, including friction. */
  void compute_forces_and_torques();
  /* The same after tangential force, compliance and loss have been advanced by a timestep dt; the force is 0 if the limit is 0. */
  void advance_forces_and_torques(double dt);
  /* Add the normal forces to those of both spheres, as far as their indices are below `owned`. */
  void add_normal(double (*forces)[3], int owned) const;
  /* Add forces and torques including friction likewise. */
  void add_forces_and_torques(double (*forces)[3], double (*torques)[3], int owned) const;

 private:
  template <bool ADVANCES> void compute_friction(double dt);
};

}    // namespace granwave

#endif
