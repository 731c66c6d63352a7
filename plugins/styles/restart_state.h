// SPDX-License-Identifier: GPL-2.0-only
/* States of fixes in restart files, with checksums: a file that was damaged ends in an error, not in other contacts. */

#ifndef GRANWAVE_RESTART_STATE_H
#define GRANWAVE_RESTART_STATE_H

#include "fix.h"

#include <cstdio>
#include <vector>

namespace granwave {

/* Checksum of numbers, itself a whole number. */
double checksum(const double *values, std::size_t n);

/* True if a number from a file is whole and lies in this range. */
bool is_whole(double value, double least, double most);

/* Write the global state of a fix; only on the first processor. */
void write_state(FILE *, const std::vector<double> &state);

/* Return the global state of a fix, of which n numbers are expected, from the buffer that LAMMPS passes to Fix::restart(). States
   of the first format have no checksum and do not tell their length. Stops with an error if the state is another one, which is
   called `other`, or damaged. */
const double *read_state(LAMMPS_NS::LAMMPS *, const LAMMPS_NS::Fix &, const char *buffer, std::size_t n,
                         const char *other = "another state");

/* State of a fix with an atom. */
struct AtomState {
  static constexpr int HEAD = 3;    // size of all, mark of the format, checksum

  const double *values;
  int n;
  bool checked;    // false for one of a format without a checksum
};

/* Complete a state of n numbers with an atom, which stand behind its head. Returns the size with the head. */
int seal_atom_state(double *buffer, int n);

/* Return the state of a fix with atom i, for Fix::unpack_restart(). Stops with an error if it is damaged. */
AtomState atom_state(LAMMPS_NS::LAMMPS *, const LAMMPS_NS::Fix &, int i, int nth);

/* Stop with an error: the state of a fix with atom i is damaged. */
[[noreturn]] void damaged_atom_state(LAMMPS_NS::LAMMPS *, const LAMMPS_NS::Fix &, int i);

}    // namespace granwave

#endif
