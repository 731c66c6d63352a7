// SPDX-License-Identifier: GPL-2.0-only
/* Batch of touching pairs as plain arrays (structure of arrays): arithmetic common to all pairs is done in loops without
   branches, which the compiler can vectorize. No LAMMPS types.

   Normal forces are Hertzian; the caller overwrites those of contacts that have yielded. Friction as in tangential.h. */

#ifndef GRANWAVE_CONTACT_BATCH_H
#define GRANWAVE_CONTACT_BATCH_H

#include "../laws/tangential.h"
#include "processors.h"

#include <cstdint>

namespace granwave {

struct ContactBatch {
  static constexpr int CAPACITY = 64;

  int size = 0;
  alignas(64) int k[CAPACITY], i[CAPACITY], j[CAPACITY];    // indices of the pair and its spheres, as set by the caller

  // input, by pair
  double del[3][CAPACITY];    // components of the vector from j to i
  double rsq[CAPACITY];       // its length squared
  double radius_i[CAPACITY], radius_j[CAPACITY], radsum[CAPACITY], root_radius[CAPACITY];    // root of R*
  double hertz[CAPACITY];                                                                    // force = hertz overlap^(3/2)
  double shear_stiffness[CAPACITY];    // k_t of a contact circle of radius 1: 8 G*
  double largest_overlap[CAPACITY];    // largest overlap without an error
  double elastic_limit[CAPACITY];      // largest Hertzian overlap
  double peak[CAPACITY];               // largest overlap before

  // output
  double r[CAPACITY], overlap[CAPACITY], force[CAPACITY];    // distance, overlap, normal force
  double circle[CAPACITY];                                   // radius of the contact circle
  double pair_force[CAPACITY];                               // normal force over distance

  // friction, input
  double friction[CAPACITY];    // coefficient
  double keeps[CAPACITY];       // 1: TangentialModel::MINDLIN, 0: MINDLIN_RESCALE
  // friction, from the spheres and springs of the pairs
  double normal[3][CAPACITY];                         // unit vector from j to i
  double limit[CAPACITY];                             // Coulomb's limit of the tangential force; 0 without friction
  double lever_i[CAPACITY], lever_j[CAPACITY];        // lever arms
  double velocity[3][CAPACITY], spin[3][CAPACITY];    // velocity of i relative to j; sum of lever arm times angular velocity
  double tangential[3][CAPACITY];                     // tangential force on i, before and after
  double compliance[CAPACITY], loss[CAPACITY];        // compliance and loss, as in TangentialSpring, before and after
  // friction, output
  double force_i[3][CAPACITY];    // force on sphere i; the force on j is opposite
  double torque[3][CAPACITY];     // torque on either sphere, per unit of its lever arm

  /* Store pair `pair` of spheres at position n: indices, vector from `second` to `first`, its length squared. */
  ALWAYS_INLINE void put(int n, int pair, int first, int second, double delx, double dely, double delz, double square)
  {
    k[n] = pair;
    i[n] = first;
    j[n] = second;
    del[0][n] = delx;
    del[1][n] = dely;
    del[2][n] = delz;
    rsq[n] = square;
  }
  /* Replace the vectors by unit normals times distance, and the squared lengths by the squares of these distances: with the same
     last bits as of pairs whose distance is not that of their centers. */
  void multiply_normals();
  /* Compute distance, overlap, Hertzian force and contact circle. Returns true if an overlap is too large or not a number. */
  bool compute_overlap();
  /* Compare the overlaps with the previous peaks: bit m of `raised` is set if that of pair m is larger, of `yielded` if the
     larger of the two is beyond the elastic limit. */
  void compare_with_peaks(std::uint64_t &raised, std::uint64_t &yielded) const;
  /* Compute normal force over distance. */
  void compute_normal();
  /* Compute normals, lever arms and Coulomb's limits. Returns true if a limit is 0. */
  bool prepare_friction();
  /* Read velocities and angular velocities of the spheres, three components each, and the springs of the pairs. */
  void read(const double *velocities, const double *omegas, const TangentialSpring *springs);
  /* Write the springs of the pairs; springs with limit 0 are left unchanged. */
  void write(TangentialSpring *springs) const;
  /* Compute forces and torques on the spheres, including friction. */
  void compute_forces_and_torques();
  /* Compute the same forces after tangential force, compliance and loss have been advanced by a timestep dt; the force is
     0 if the limit is 0. */
  void advance_forces_and_torques(double dt);
  /* Add the normal forces to both spheres if their indices are below `owned`. */
  void add_normal(double *forces, int owned) const;
  /* Add forces and torques including friction in the same way, and meanwhile prefetch springs of later pairs. */
  void add_forces_and_torques(double *forces, double *torques, int owned, const TangentialSpring *springs) const;
  /* Add them with torques of rolling and twisting on sphere i and opposite torques on j. */
  void add_forces_and_moments(double *forces, double *torques, int owned, const double (*moment)[3]) const;

 private:
  template <bool ADVANCES> void compute_friction(double dt);
};

}    // namespace granwave

#endif
