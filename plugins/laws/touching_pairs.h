// SPDX-License-Identifier: GPL-2.0-only
/* Search for the touching pairs of a half neighbor list, from row to row. No LAMMPS types.

   A pair is written to the batch whether it touches or not, and the next one takes its place if it does not: in a rattling
   packing the outcome is unpredictable, and a mispredicted branch would cost more than the distance. */

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

  // the list: spheres of the rows, first pair of each row (and of the one beyond the last), partners
  const int *row, *begin, *partner;
  const double *x;         // coordinates of all spheres, and one number more
  const double *radius;    // null if all are equal to uniform_radius
  double uniform_radius, gap;
  const char *has_spring;    // by pair; null without friction

  // by pair: read soon if it touches
  const double *peak;
  const TangentialSpring *spring;

  // found by collect(), for the caller to deal with
  int n_released, n_far;
  int released[ContactBatch::CAPACITY];    // pairs that have a spring and do not touch
  std::vector<int> far;                    // rows with pairs beyond the gap

  /* Search the rows from `first` up to the one before `last`. */
  void start(int first, int last)
  {
    r = first;
    end = last;
    pair = begin[first];
    if (static_cast<int>(far.size()) < last - first) far.resize(last - first);
  }

  /* Put touching pairs into an empty batch. Returns false if there is no room for more, and the search must go on. */
  bool collect(ContactBatch &);

 private:
  int r, pair, end;    // where the search goes on, and the row where it ends
  template <bool UNIFORM, bool FRICTION> bool search(ContactBatch &);
};

}    // namespace granwave

#endif
