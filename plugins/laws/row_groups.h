// SPDX-License-Identifier: GPL-2.0-only
/* Groups of consecutive rows of a half neighbor list whose partners are consecutive spheres, too: in an ordered packing the
   partners of sphere i + 1 are mostly those of sphere i, each plus 1. Distances of a group are computed without indices. No
   LAMMPS types. */

#ifndef GRANWAVE_ROW_GROUPS_H
#define GRANWAVE_ROW_GROUPS_H

#include <algorithm>
#include <cstdint>
#include <vector>

namespace granwave {

/* Pair `pair` + l `stride` + m is that of the spheres `sphere` + l and partner[m] + l, with l < lanes and m < partners. */
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

  /* True if the spheres of row r + l are those of row r, each plus l. */
  static bool follows(int r, int l, const std::vector<int> &row, const std::vector<int> &begin,
                      const std::vector<int> &partner)
  {
    if (row[r + l] != row[r] + l || begin[r + l + 1] - begin[r + l] != begin[r + 1] - begin[r]) return false;
    for (int m = 0; m < begin[r + 1] - begin[r]; m++)
      if (partner[begin[r + l] + m] != partner[begin[r] + m] + l) return false;
    return true;
  }
};

}    // namespace granwave

#endif
