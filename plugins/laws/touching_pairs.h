// SPDX-License-Identifier: GPL-2.0-only
/* Search for the touching pairs of a half neighbor list, from row to row. No LAMMPS types.

   Distances of many pairs are computed first, four at a time. The pairs that touch are then picked out without branches: in a
   rattling packing the outcome is unpredictable, and a mispredicted branch would cost more than the distance. */

#ifndef GRANWAVE_TOUCHING_PAIRS_H
#define GRANWAVE_TOUCHING_PAIRS_H

#include "contact_batch.h"

#include <vector>

namespace granwave {

struct TouchingPairs {
  // Spheres of a lattice that just touch have an overlap or gap due to the rounding of their positions. Overlaps below this
  // fraction of the distance are neglected: their force would be below 1e-12 F_y.
  static constexpr double ROUNDING = 5e-13;
  static double touch_squared(double radsum) { return radsum * radsum * (1.0 - 2.0 * ROUNDING); }

  static constexpr int CHUNK = 256;    // pairs whose distances are computed at a time: those of some 32 spheres

  // the list: spheres of the rows, first pair of each row (and of the one beyond the last), partners
  const int *row, *begin, *partner;
  const double *x;         // coordinates of all spheres, and one number more
  const double *radius;    // null if all are equal to uniform_radius
  double uniform_radius, gap;
  const char *has_spring;    // by pair; null without friction
  const double *peak;        // by pair: needed for those that touch

  // found by collect(), for the caller to deal with
  int n_released, n_far;
  int released[CHUNK];     // pairs that have a spring and do not touch
  std::vector<int> far;    // rows with pairs beyond the gap

  /* Search the rows from `first` up to the one before `last`. */
  void start(int first, int last)
  {
    r = first;
    end = last;
    pair = begin[first];
    n_found = taken = 0;
    if (static_cast<int>(far.size()) < last - first) far.resize(last - first);
  }

  /* Put touching pairs into an empty batch. Returns false if there is no room for more, and the search must go on. */
  bool collect(ContactBatch &);

 private:
  static constexpr int GROUP = ContactBatch::GROUP;

  int r, pair, end;    // where the search goes on, and the row where it ends
  // pairs of the last search, from pair `base` on: their number, sphere of the row, distance squared; those that touch
  int base, n_found, taken;
  int sphere[CHUNK + GROUP], found[CHUNK + GROUP];
  double rsq[CHUNK + GROUP];

  template <bool UNIFORM> void search();
  template <bool UNIFORM> void compute_distances(int count, bool &any_far);
  void find_far(int first_row, int count);
  void find_released(int count);
};

}    // namespace granwave

#endif
