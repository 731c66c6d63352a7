// SPDX-License-Identifier: GPL-2.0-only
/* Search for the touching pairs of a half neighbor list, from one group of rows (row_groups.h) to the next. No LAMMPS types.

   Distances are computed for four rows at a time, from coordinates in arrays of their own. The outcome is a word of bits: in a
   rattling packing it is unpredictable, and a mispredicted branch would cost more than a distance. */

#ifndef GRANWAVE_TOUCHING_PAIRS_H
#define GRANWAVE_TOUCHING_PAIRS_H

#include "contact_batch.h"
#include "row_groups.h"

#include <cstdint>
#include <vector>

namespace granwave {

struct TouchingPairs {
  // Spheres of a lattice that just touch have an overlap or gap due to the rounding of their positions. Overlaps below this
  // fraction of the distance are neglected: their force would be below 1e-12 F_y.
  static constexpr double ROUNDING = 5e-13;
  static double touch_squared(double radsum) { return radsum * radsum * (1.0 - 2.0 * ROUNDING); }

  const double *x, *y, *z;    // coordinates of all spheres, and RowGroup::LANES numbers more
  const double *radius;       // likewise; null if all are equal to uniform_radius
  double uniform_radius, gap;

  // found by collect(), for the caller to deal with
  std::vector<int> parted;    // pairs that touched and do no longer
  std::vector<int> far;       // rows with pairs beyond the gap

  /* Search the groups from `first` up to the one before `last`. Their touching pairs (RowGroups::bits) are updated, and parted
     ones found, unless `touched` is null. */
  void start(const RowGroup *first, const RowGroup *last, std::uint64_t *touched)
  {
    group = first;
    end = last;
    before = touched;
    measured = false;
  }

  /* Add touching pairs to a batch. Returns false if there is no room for more, and the search must go on. */
  bool collect(ContactBatch &);

 private:
  struct Distances {    // of a group, from partner to row
    alignas(64) double delx[RowGroup::PARTNERS][RowGroup::LANES], dely[RowGroup::PARTNERS][RowGroup::LANES];
    double delz[RowGroup::PARTNERS][RowGroup::LANES], rsq[RowGroup::PARTNERS][RowGroup::LANES];
  };

  const RowGroup *group, *end;    // where the search goes on, and where it ends
  bool measured;                  // true if distances and touching are those of the present group
  Distances distances;
  std::uint64_t touching;    // bits of the pairs that are still to be put into a batch
  std::uint64_t *before;     // bits of the pairs of the present group that touched when it was searched last, or null

  template <bool UNIFORM> void measure();
  void compare();
  template <bool UNIFORM> int search_row(ContactBatch &, int n);
  template <bool UNIFORM> bool search(ContactBatch &);
};

}    // namespace granwave

#endif
