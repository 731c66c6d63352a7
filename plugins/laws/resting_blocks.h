// SPDX-License-Identifier: GPL-2.0-only
/* Blocks of consecutive spheres that nothing has reached yet. No LAMMPS types.

   The rows of a half neighbor list are evaluated block by block. A block in which no pair touched at the last evaluation can
   be skipped as long as none of its spheres and of their partners has moved: distances are the same to the last bit, so
   nothing touches again. What has moved is found by comparing coordinates with those of the last evaluation, whatever moved
   them. */

#ifndef GRANWAVE_RESTING_BLOCKS_H
#define GRANWAVE_RESTING_BLOCKS_H

#include "row_groups.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

namespace granwave {

/* Copy the coordinates of n spheres, three a sphere, to arrays of x, y and z, and set for each block of `size` spheres whether one
   of its coordinates is another than in these before. It need not be copied where none is. `moved` holds the results of the
   last call. */
void compare_blocks(const double *coordinates, int n, int size, double *x, double *y, double *z, char *moved);

class RestingBlocks {
 public:
  // spheres of a block: enough for its checks to cost little, yet the wave front is sharp
  static constexpr int BITS = 5, SIZE = 1 << BITS;

  static constexpr int PADDING = RowGroup::LANES;    // so that as many can be read from any sphere on

  static int of(int i) { return i / SIZE; }
  static int number(int n) { return (n + SIZE - 1) / SIZE; }

  /* Start anew with a list of rows, whose pairs begin[r] to begin[r + 1] are with the spheres `partner`. Nothing rests. */
  void build(const std::vector<int> &row, const std::vector<int> &begin, const std::vector<int> &partner)
  {
    const int rows = static_cast<int>(row.size());
    first_.clear();
    needed_.clear();
    std::vector<int> found_for;    // last block of rows that needed a block of spheres
    for (int r = 0; r < rows; r++) {
      const int block = of(r);
      if (r % SIZE == 0) first_.push_back(static_cast<int>(needed_.size()));
      const auto need = [&](int i) {
        const std::size_t other = of(i);
        if (other >= found_for.size()) found_for.resize(other + 1, -1);
        if (found_for[other] == block) return;
        found_for[other] = block;
        needed_.push_back(static_cast<int>(other));
      };
      need(row[r]);
      for (int k = begin[r]; k < begin[r + 1]; k++) need(partner[k]);
    }
    first_.push_back(static_cast<int>(needed_.size()));
    quiet_.assign(number(rows), 0);
    n_ = -1;
  }

  /* Compare the coordinates of n spheres, and radii, with those of the last call. Returns true in the first call, and if a
     radius has changed. */
  bool compare(const double *x, int n, const double *radius, int radii)
  {
    moved_.resize(number(n));
    const bool first = n != n_ || last_radius_.size() != static_cast<std::size_t>(radii) + PADDING ||
                       std::memcmp(last_radius_.data(), radius, radii * sizeof(double)) != 0;
    if (first) {
      n_ = n;
      for (auto &last : last_) last.assign(n + PADDING, 0.0);
      last_radius_.assign(radius, radius + radii);
      last_radius_.resize(radii + PADDING, 0.0);
      std::fill(moved_.begin(), moved_.end(), 1);
    }
    compare_blocks(x, n, SIZE, last_[0].data(), last_[1].data(), last_[2].data(), moved_.data());
    if (first) std::fill(moved_.begin(), moved_.end(), 1);
    return first;
  }

  /* Coordinates of the spheres as of the last comparison, along x, y or z, and PADDING numbers more. */
  const double *coordinates(int axis) const { return last_[axis].data(); }
  /* Radii as of the last comparison, likewise. */
  const double *radii() const { return last_radius_.data(); }

  /* Return true if the rows of this block need not be evaluated. */
  bool rests(int block) const
  {
    if (!quiet_[block]) return false;
    for (int k = first_[block]; k < first_[block + 1]; k++)
      if (moved_[needed_[k]]) return false;
    return true;
  }

  /* Set whether no pair of a block touched in the evaluation just done. */
  void set_quiet(int block, bool quiet) { quiet_[block] = quiet; }

  /* Have all blocks evaluated next time, after a change of their history. */
  void disturb() { std::fill(quiet_.begin(), quiet_.end(), 0); }

  double bytes() const
  {
    return static_cast<double>((first_.capacity() + needed_.capacity()) * sizeof(int) + quiet_.capacity() +
                               moved_.capacity() + (3 * last_[0].capacity() + last_radius_.capacity()) * sizeof(double));
  }

 private:
  std::vector<int> first_, needed_;    // of each block of rows: blocks of their spheres and partners
  std::vector<char> quiet_, moved_;
  int n_ = -1;    // number of spheres at the last comparison
  std::vector<double> last_[3], last_radius_;
};

}    // namespace granwave

#endif
