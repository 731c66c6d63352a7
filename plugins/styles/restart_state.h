// SPDX-License-Identifier: GPL-2.0-only
/* States of pair style and fixes in restart files, with checksums: a damaged file gives an error, not wrong contacts. */

#ifndef GRANWAVE_RESTART_STATE_H
#define GRANWAVE_RESTART_STATE_H

#include "fix.h"

#include <cstdio>
#include <string>
#include <vector>

namespace granwave {

/* Write the state of the pair style or the global state of a fix; only on the first processor. */
void write_state(FILE *, const std::vector<double> &state);

/* Return the global state of a fix, of which n numbers are expected, from the buffer that LAMMPS passes to Fix::restart(). Stops
   with an error if the state is another one, which is called `other`, or damaged. */
std::vector<double> read_state(LAMMPS_NS::LAMMPS *, const LAMMPS_NS::Fix &, const char *buffer, std::size_t n,
                               const char *other = "another state");

/* Read a state of the pair style on all processors. Stops with an error if it, called `what`, is damaged. */
std::vector<double> read_state(LAMMPS_NS::LAMMPS *, FILE *, const std::string &what);

/* State of a fix with an atom. */
struct AtomState {
  static constexpr int HEAD = 7;    // size of all, mark of the format, checksum, ID and position of the atom

  const double *values;
  int n;
};

/* Complete a state of n numbers, which follow its head, with atom i. Returns the size with the head. */
int seal_atom_state(const LAMMPS_NS::LAMMPS *, int i, double *buffer, int n);

/* Return the state of a fix with atom i, for Fix::unpack_restart(). Stops with an error if it is damaged, or of
   another atom: between read_restart and the fix LAMMPS does not move the states with the atoms, which may get other IDs, too. */
AtomState atom_state(LAMMPS_NS::LAMMPS *, const LAMMPS_NS::Fix &, int i, int nth);

}    // namespace granwave

#endif
