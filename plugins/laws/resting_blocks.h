// SPDX-License-Identifier: GPL-2.0-only
/* Blocks of consecutive spheres that nothing has reached yet. No LAMMPS types.

   The rows of a half neighbor list are evaluated block by block. A block in which no pair touched at the last evaluation can
   be skipped as long as none of its spheres and of their partners has moved: distances are the same to the last bit, so
   nothing touches again. What has moved is found by comparing coordinates with those of the last evaluation, whatever moved
   them. */

#ifndef GRANWAVE_RESTING_BLOCKS_H
#define GRANWAVE_RESTING_BLOCKS_H

#include <algorithm>
#include <cstring>
#include <vector>

namespace granwave {

class RestingBlocks {
 public:
  static constexpr int SIZE =
      32;    // spheres of a block: large enough for its checks to cost little, yet the wave front is sharp

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
    last_.clear();
  }

  /* Compare the coordinates of n spheres, and radii, with those of the last call. Returns true in the first call, and if a
     radius has changed. */
  bool compare(const double *x, int n, const double *radius, int radii)
  {
    moved_.resize(number(n));
    if (last_.size() != 3 * static_cast<std::size_t>(n) + 1 || last_radius_.size() != static_cast<std::size_t>(radii) ||
        std::memcmp(last_radius_.data(), radius, radii * sizeof(double)) != 0) {
      last_.assign(x, x + 3 * static_cast<std::size_t>(n));
      last_.push_back(0.0);
      last_radius_.assign(radius, radius + radii);
      std::fill(moved_.begin(), moved_.end(), 1);
      return true;
    }
    for (int b = 0; b < number(n); b++) {
      const std::size_t begin = 3 * static_cast<std::size_t>(b) * SIZE,
                        bytes = 3 * std::min(SIZE, n - b * SIZE) * sizeof(double);
      moved_[b] = std::memcmp(last_.data() + begin, x + begin, bytes) != 0;
      if (moved_[b]) std::memcpy(last_.data() + begin, x + begin, bytes);
    }
    return false;
  }

  /* Coordinates of the spheres as of the last comparison, and one number more, so that four can be read for each sphere. */
  const double *x() const { return last_.data(); }

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
                               moved_.capacity() + (last_.capacity() + last_radius_.capacity()) * sizeof(double));
  }

 private:
  std::vector<int> first_, needed_;    // of each block of rows: blocks of their spheres and partners
  std::vector<char> quiet_, moved_;
  std::vector<double> last_, last_radius_;
};

}    // namespace granwave

#endif
