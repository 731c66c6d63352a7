// SPDX-License-Identifier: GPL-2.0-only
/* Velocities of ghost spheres, sent from their owners in each step where laws need them.

   LAMMPS sends velocity and angular velocity of every ghost with its position (comm_modify vel yes): 72 bytes in place of 24. In an
   impact most spheres are at rest. Here a bit for each ghost says whether it moves, and only velocities that are not 0 follow, angular
   ones only where laws need them. The values of ghosts are those that LAMMPS would send, to the last bit. */

#ifndef GRANWAVE_GHOST_VELOCITIES_H
#define GRANWAVE_GHOST_VELOCITIES_H

#include "pointers.h"

#include <vector>

namespace granwave {

class GhostVelocities {
 public:
  static constexpr int SIZE = 1 + 6;    // most numbers for each ghost

  /* Send angular velocities of ghosts if they are needed too. */
  void start(LAMMPS_NS::LAMMPS *, bool turn);

  /* Discard the stored velocities: there are new ghosts, for which nothing has been received. */
  void renew();

  /* Write the velocities of these atoms, as seen by ghosts behind a periodic boundary, to a buffer; returns the number of
     values. */
  int pack(int n, const int *atoms, double *buffer, bool crosses, const int *images) const;
  void unpack(int n, int first, const double *buffer);

 private:
  LAMMPS_NS::LAMMPS *lmp = nullptr;
  bool turns = false;
  std::vector<char> at_rest;    // by index: true if the arrays hold velocities of 0
};

}    // namespace granwave

#endif
