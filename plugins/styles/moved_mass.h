// SPDX-License-Identifier: GPL-2.0-only
/* Effective masses of spheres in a contact, for dashpots.

   A force F accelerates a sphere by P F/m, so that along a unit normal n it counts with the mass m/(n.P n). P is the unit matrix of
   a free sphere, and 0 of one whose motion no force changes: a sphere of fix freeze, one that is in no group of an integrating fix,
   or only of fixes that prescribe the motion (fix move, fix nve/noforce, fix gran/load with a displacement). Of fix setforce,
   lineforce and planeforce P is what they leave of a force: these fixes are asked, since they do not show their settings. A sphere
   of a rigid body has the mass of the body, as in the granular styles of LAMMPS. */

#ifndef GRANWAVE_MOVED_MASS_H
#define GRANWAVE_MOVED_MASS_H

#include "../kernels/stored.h"

#include "fix.h"

#include <vector>

namespace granwave {

/* Bits of the groups whose spheres follow the forces on them: groups of fixes that integrate and do not prescribe the
   motion. */
int integrated_groups(const LAMMPS_NS::LAMMPS *);

class MovedMass {
 public:
  static constexpr int BODY = -1;       // in place of a sphere: a body for which only the inverse mass matters
  static constexpr int SIZE = 1 + 6;    // numbers for each sphere

  /* Find the fixes that hold and integrate spheres, at the start of a run. Of the fixes that change forces those before `fix`
     do not count if it is given: they do not see its forces. */
  void find(LAMMPS_NS::LAMMPS *, const LAMMPS_NS::Fix *fix = nullptr);

  /* True if a sphere may be held, or belong to a rigid body; the same on all processors. */
  bool differ() const { return differs; }

  /* Determine the masses of the owned spheres. A collective call, after each reneighboring. */
  void update();

  /* Copy the numbers of a sphere to a buffer, or from one to a ghost. */
  void pack(int i, double *buffer) const;
  void unpack(int i, const double *buffer);

  /* Effective mass 1/(1/m_i + 1/m_j + others) of two bodies along their unit normal, with the inverse masses of other bodies.
     Where nothing can move along the normal, that of the same spheres without what holds them. */
  double effective(int i, int j, const double normal[3], double others = 0.0) const;

 private:
  struct Sphere {
    double body;       // mass of its rigid body, 0 if there is none
    double left[6];    // P: xx, yy, zz, xy, xz, yz
  };
  static_assert(doubles_of<Sphere>() == SIZE);

  double mass(int i) const;
  void ask_holders();

  LAMMPS_NS::LAMMPS *lmp = nullptr;
  bool differs = false;
  int frozen = 0;                           // bits of the groups of fix freeze
  int integrated = 0;                       // bits of the groups whose spheres follow the forces on them
  std::vector<LAMMPS_NS::Fix *> rigid;      // fixes of rigid bodies
  std::vector<LAMMPS_NS::Fix *> holders;    // fixes that remove components of a force
  std::vector<Sphere> spheres;              // for owned spheres and ghosts; empty if they do not differ
};

}    // namespace granwave

#endif
