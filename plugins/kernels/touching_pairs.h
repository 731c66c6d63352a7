// SPDX-License-Identifier: GPL-2.0-only
/* Search for the touching pairs of a half neighbor list. No LAMMPS types.

   Groups are of consecutive rows whose partners are consecutive spheres, too: in an ordered packing the partners of sphere
   i + 1 are mostly those of sphere i, each plus 1. Distances of a group are computed without indices, for four rows at a time,
   from coordinates in arrays of their own. The outcome is a word of bits: in a rattling packing it is unpredictable, and a
   mispredicted branch would cost more than a distance.

   Blocks are of consecutive rows. A block in which no pair touched at the last evaluation can be skipped as long as none of its
   spheres and of their partners has moved: distances are the same to the last bit, so nothing touches again. What has moved is
   found by comparing coordinates with those of the last evaluation, whatever moved them. */

#ifndef GRANWAVE_TOUCHING_PAIRS_H
#define GRANWAVE_TOUCHING_PAIRS_H

#include "contact_batch.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace granwave {

/* Pair `pair` + l `stride` + m has the spheres `sphere` + l and partner[m] + l, with l < lanes and m < partners. */
struct RowGroup {
  static constexpr int LANES = 8, PARTNERS = 8;    // at most; a row with more partners is in several groups

  int row, sphere, lanes, pair, stride, partners;
  int partner[PARTNERS];
};

class RowGroups {
 public:
  /* Group the rows, whose pairs begin[r] to begin[r + 1] are with the spheres `partner`; no group crosses the blocks of rows. */
  void build(const std::vector<int> &row, const std::vector<int> &begin, const std::vector<int> &partner, int block)
  {
    const int rows = static_cast<int>(row.size());
    groups_.clear();
    first_.clear();
    for (int r = 0, lanes; r < rows; r += lanes) {
      if (r % block == 0) first_.push_back(static_cast<int>(groups_.size()));
      const int most = std::min({RowGroup::LANES, rows - r, block - r % block}), stride = begin[r + 1] - begin[r];
      for (lanes = 1; lanes < most && follows(r, lanes, row, begin, partner);) lanes++;
      for (int m = 0; m < stride; m += RowGroup::PARTNERS) {
        groups_.push_back({r, row[r], lanes, begin[r] + m, stride, std::min(stride - m, RowGroup::PARTNERS), {}});
        std::copy_n(partner.begin() + begin[r] + m, groups_.back().partners, groups_.back().partner);
      }
    }
    first_.push_back(static_cast<int>(groups_.size()));
  }

  const RowGroup *begin(int block) const { return groups_.data() + first_[block]; }
  const RowGroup *end(int block) const { return groups_.data() + first_[block + 1]; }
  int first(int block) const { return first_[block]; }    // index of the first group of a block

  /* For each group the pairs k with has(k), as a word: bit m of byte l is that of pair `pair` + l `stride` + m. */
  template <class Has> std::vector<std::uint64_t> bits(const Has &has) const
  {
    std::vector<std::uint64_t> words;
    words.reserve(groups_.size());
    for (const RowGroup &g : groups_) {
      std::uint64_t word = 0;
      for (int l = 0; l < g.lanes; l++)
        for (int m = 0; m < g.partners; m++) word |= std::uint64_t(has(g.pair + l * g.stride + m) ? 1 : 0) << (8 * l + m);
      words.push_back(word);
    }
    return words;
  }

  double bytes() const
  {
    return static_cast<double>(groups_.capacity()) * sizeof(RowGroup) + static_cast<double>(first_.capacity()) * sizeof(int);
  }

 private:
  std::vector<RowGroup> groups_;
  std::vector<int> first_;    // group of each block of rows, and the number of groups

  /* True if the spheres of row r + l are the spheres of row r, with indices increased by l. */
  static bool follows(int r, int l, const std::vector<int> &row, const std::vector<int> &begin,
                      const std::vector<int> &partner)
  {
    if (row[r + l] != row[r] + l || begin[r + l + 1] - begin[r + l] != begin[r + 1] - begin[r]) return false;
    for (int m = 0; m < begin[r + 1] - begin[r]; m++)
      if (partner[begin[r + l] + m] != partner[begin[r] + m] + l) return false;
    return true;
  }
};

/* Copy the coordinates of n spheres, three a sphere, to arrays of x, y and z, and set for each block of `size` spheres whether one
   of its coordinates is another than in these before. It need not be copied where none is. `moved` holds the results of the
   last call. */
void compare_blocks(const double *coordinates, int n, int size, double *x, double *y, double *z, char *moved);

/* Return true if n numbers are 0, and if they are finite. */
bool all_zero(const double *numbers, int n);
bool all_finite(const double *numbers, int n);

class RestingBlocks {
 public:
  // spheres of a block: enough for low overhead of its checks, yet the wave front stays sharp
  static constexpr int BITS = 5, SIZE = 1 << BITS;

  static constexpr int PADDING = RowGroup::LANES;    // padding, so that this number can be read starting at any sphere

  static int of(int i) { return i / SIZE; }
  static int number(int n) { return (n + SIZE - 1) / SIZE; }

  /* Restart with a list of rows, whose pairs begin[r] to begin[r + 1] are with the spheres `partner`. Nothing rests. */
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

  /* Compare the coordinates of n spheres, and radii, with the last call. Returns true in the first call, and if a
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

  /* Coordinates of the spheres at the last comparison, along x, y or z, followed by PADDING further numbers. */
  const double *coordinates(int axis) const { return last_[axis].data(); }
  /* Radii at the last comparison, followed by PADDING further numbers. */
  const double *radii() const { return last_radius_.data(); }

  /* Return true if the rows of this block need not be evaluated. */
  bool rests(int block) const
  {
    if (!quiet_[block]) return false;
    for (int k = first_[block]; k < first_[block + 1]; k++)
      if (moved_[needed_[k]]) return false;
    return true;
  }

  /* Return true if a sphere of the block of sphere i has moved. */
  bool moved(int i) const { return moved_[of(i)]; }

  /* Set whether no pair of a block touched in the last evaluation. */
  void set_quiet(int block, bool quiet) { quiet_[block] = quiet; }

  /* Mark all blocks for the next evaluation, after a change of their history. */
  void disturb() { std::fill(quiet_.begin(), quiet_.end(), 0); }

  double bytes() const
  {
    return static_cast<double>((first_.capacity() + needed_.capacity()) * sizeof(int) + quiet_.capacity() +
                               moved_.capacity() + (3 * last_[0].capacity() + last_radius_.capacity()) * sizeof(double));
  }

 private:
  std::vector<int> first_, needed_;    // for each block of rows: blocks of their spheres and partners
  std::vector<char> quiet_, moved_;
  int n_ = -1;    // number of spheres at the last comparison
  std::vector<double> last_[3], last_radius_;
};

/* Search from one group of rows to the next. */
struct TouchingPairs {
  // Spheres of a lattice that just touch have an overlap or gap due to the rounding of their positions. Overlaps below this
  // fraction of the distance are neglected: their force would be below 1e-12 F_y.
  static constexpr double ROUNDING = 5e-13;
  static double touch_squared(double radsum) { return radsum * radsum * (1.0 - 2.0 * ROUNDING); }

  const double *x, *y, *z;    // coordinates of all spheres, and RowGroup::LANES numbers more
  const double *radius;       // likewise; null if all are equal to uniform_radius
  double uniform_radius, gap;

  // found by collect(), for further treatment by the caller
  std::vector<int> parted;    // pairs that have separated
  std::vector<int> far;       // pairs beyond the gap

  /* Search the groups from `first` up to the one before `last`. Their touching pairs (RowGroups::bits) are updated, and
     separated ones found, unless `touched` is null. */
  void start(const RowGroup *first, const RowGroup *last, std::uint64_t *touched)
  {
    group = first;
    end = last;
    before = touched;
    measured = false;
  }

  /* Add touching pairs to a batch. Returns false if the batch is full, and the search must continue later. */
  bool collect(ContactBatch &);

 private:
  struct Distances {    // of a group, from partner to row
    alignas(64) double delx[RowGroup::PARTNERS][RowGroup::LANES], dely[RowGroup::PARTNERS][RowGroup::LANES];
    double delz[RowGroup::PARTNERS][RowGroup::LANES], rsq[RowGroup::PARTNERS][RowGroup::LANES];
  };

  const RowGroup *group, *end;    // position at which the search continues, and its end
  bool measured;                  // true if distances and contacts are those of the present group
  Distances distances;
  std::uint64_t touching;    // bits of the pairs that have not been put into a batch yet
  std::uint64_t *before;     // bits of the pairs of the present group that touched when it was searched last, or null

  int pair_of(int bit) const { return group->pair + (bit >> 3) * group->stride + (bit & 7); }    // of the present group
  template <bool UNIFORM> void measure();
  void compare();
  template <bool UNIFORM> int search_row(ContactBatch &, int n);
  template <bool UNIFORM> bool search(ContactBatch &);
};

}    // namespace granwave

#endif
