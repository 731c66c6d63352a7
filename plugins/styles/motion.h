// SPDX-License-Identifier: GPL-2.0-only
/* Common functions of the styles: checks that motion is finite, the time, numbers and files of commands.

   The checks of LAMMPS itself do not detect a NaN: every comparison with NaN is false, so that such an atom never counts as
   moved, and the neighbor lists are not rebuilt. */

#ifndef GRANWAVE_MOTION_H
#define GRANWAVE_MOTION_H

#include "atom.h"
#include "fix.h"
#include "update.h"

#include <fstream>
#include <string>
#include <vector>

namespace granwave {

/* Components of the vectors of all spheres, which LAMMPS stores contiguously. */
inline double *components(double **vectors) { return vectors[0]; }

/* Stop with an error if the motion of atom i is not finite (of a ghost atom only its position is checked). */
void require_finite_motion(LAMMPS_NS::LAMMPS *, int i);

/* Stop with an error at the first atom of this processor whose motion is not finite. */
void require_finite_motion(LAMMPS_NS::LAMMPS *);

/* Return the possible causes of an overlap as large as a radius, the most likely cause first: before the first step the
   bodies were placed so (`placed` says it); later the load, unless their speed is a large part of the radius in one
   timestep. */
std::string causes_of_overlap(LAMMPS_NS::LAMMPS *, double speed, double radius, const std::string &placed);

/* Return the speed of an atom of this processor, and 0 for a ghost. */
double speed_of(LAMMPS_NS::LAMMPS *, int i);

/* True in `rerun`, whose snapshots have no steps between them: no run is set up at a step other than its first. */
bool is_rerun(const LAMMPS_NS::Update &);

/* Mass of an atom of any style. */
inline double mass_of(const LAMMPS_NS::Atom *atom, int i)
{
  return atom->rmass ? atom->rmass[i] : atom->mass[atom->type[i]];
}

/* Stop with an error with run_style respa, with which `what` does not work. */
void refuse_respa(LAMMPS_NS::LAMMPS *, const std::string &what);

/* Return the number in a word of a fix; stop with an error if it is not positive (or 0, where allowed). */
double positive_number(LAMMPS_NS::LAMMPS *, const std::string &style, const std::string &name, const char *word,
                       bool may_be_zero = false);

/* Row of a text file that is not empty: its number, and its words up to a #. */
struct TextRow {
  LAMMPS_NS::bigint number;
  std::string text;
  std::vector<std::string> words;
};

/* Rows of a text file of any size. The first processor reads them and passes them to all others, in pieces of a few megabytes. */
class TextRows {
 public:
  /* Stops with an error, `fault`, if the file cannot be read. */
  TextRows(LAMMPS_NS::LAMMPS *, const std::string &file, const std::string &fault);

  /* Replace the rows by those of the next piece; false at the end of the file. A collective call. */
  bool next(std::vector<TextRow> &rows);

 private:
  LAMMPS_NS::LAMMPS *lmp_;
  std::ifstream stream_;    // on the first processor
  LAMMPS_NS::bigint number_ = 0;

  void read_piece(std::string &text, std::vector<LAMMPS_NS::bigint> &numbers);
};

/* Read a text file on all processors. Stops with an error, `fault`, if that cannot be. */
std::vector<TextRow> read_rows(LAMMPS_NS::LAMMPS *, const std::string &file, const std::string &fault);

/* Stop with an error in units in which force is not mass times acceleration (real, metal, electron). */
void require_mechanical_units(LAMMPS_NS::LAMMPS *, const std::string &what);

/* True if a fix may change radii during a run: the radii at the start then give no bound. */
bool radii_may_change(LAMMPS_NS::LAMMPS *);

/* Simulation time of a force evaluation, bitwise identical for any division of a simulation into runs. */
double simulated_time(const LAMMPS_NS::Update &);

}    // namespace granwave

#endif
