// SPDX-License-Identifier: GPL-2.0-only
/* Pairs of spheres within reach, in rows, and which of them are in two such lists, from one reneighboring to the next. */

#ifndef GRANWAVE_PAIR_ROWS_H
#define GRANWAVE_PAIR_ROWS_H

#include "lmptype.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace granwave {

/* Pairs within reach, in rows of the spheres with the lower ID (add_rows); behind them, in rows of their own, the special pairs. */
class PairRows {
 public:
  using tagint = LAMMPS_NS::tagint;
  struct Sphere {
    double radius;
    tagint tag;
    int type;
    std::int64_t birth;    // contact_history.h

    bool is(const Sphere &other) const { return tag == other.tag && birth == other.birth; }
  };

  int plain = 0;                  // number of rows of pairs of spheres with laws that depend on their radii
  int owned = 0;                  // number of owned spheres when the list was built
  std::vector<int> row, begin;    // sphere of each row, local or ghost; index of its first pair (one element longer)
  std::vector<int> partner;       // local or ghost index
  std::vector<Sphere> spheres;    // by local or ghost index, also after LAMMPS has reordered the atoms

  int rows() const { return static_cast<int>(row.size()); }
  int size() const { return static_cast<int>(partner.size()); }
  const Sphere &sphere_of_row(int r) const { return spheres[row[r]]; }
  const Sphere &partner_of_pair(int k) const { return spheres[partner[k]]; }
  /* Row of pair k. */
  int row_of(int k) const { return static_cast<int>(std::upper_bound(begin.begin(), begin.end(), k) - begin.begin()) - 1; }

  /* Call a function for each row r and pair k with the indices i and j of its spheres. */
  template <class Visit> void each_pair(const Visit &visit) const
  {
    for (int r = 0; r < rows(); r++)
      for (int k = begin[r]; k < begin[r + 1]; k++) visit(r, k, row[r], partner[k]);
  }

  /* Row and index of the pair of these IDs, the lower first; -1 if it is not in the list. Across a periodic boundary it may be
     twice in it, with the same history. */
  std::pair<int, int> find(tagint lower, tagint higher) const;

  /* Index of the pair of these spheres, the one with the lower ID first; -1 if it is not in the list. */
  int find(const Sphere &lower, const Sphere &higher) const;

  double bytes() const;

 protected:
  void clear();
  /* Append the rows of these pairs of atoms. */
  void add_rows(const std::vector<std::pair<int, int>> &, const tagint *tag, int nall);

 private:
  std::pair<int, int> search(tagint lower, tagint higher, int first, int last) const;
};

/* The pairs that two lists have in common, and what is carried from one to the other. */
class CommonPairs {
 public:
  CommonPairs(const PairRows &before, const PairRows &after);

  /* Call a function for each row r and pair k of the first list that is not in a run. */
  template <class Visit> void each_left_out(const PairRows &before, const Visit &visit) const
  {
    int r = 0, k = 0;
    for (std::size_t n = 0; n <= runs_.size(); n++) {
      const int end = n < runs_.size() ? runs_[n].from : n_before_;
      for (; k < end; k++) {
        while (before.begin[r + 1] <= k) r++;
        visit(r, k);
      }
      if (n < runs_.size()) k = end + runs_[n].n;
    }
  }

  /* Indices in both lists of the pairs that are not in a run: their spheres have several rows, or have crossed a periodic boundary. */
  const std::vector<std::pair<int, int>> &scattered() const { return scattered_; }

  bool identical() const { return runs_.size() == 1 && runs_[0].n == n_before_ && runs_[0].n == n_after_; }

  /* Move the elements of the runs, `width` a pair, to their places in the second list; all others there are `blank`. */
  template <class T> void carry(std::vector<T> &values, const T &blank, int width = 1) const
  {
    if (identical() || width == 0) return;
    const std::size_t most = static_cast<std::size_t>(std::max(n_before_, n_after_)) * width;
    if (values.capacity() < most) values.reserve(most + most / SPARE);
    values.resize(most, blank);
    for (std::size_t n = 0; n < runs_.size();) n = move_stretch(values, n, width);
    int filled = 0;
    for (const Run &run : runs_) {
      std::fill(at(values, filled, width), at(values, run.to, width), blank);
      filled = run.to + run.n;
    }
    std::fill(at(values, filled, width), at(values, n_after_, width), blank);
    values.resize(static_cast<std::size_t>(n_after_) * width, blank);
  }

 private:
  static constexpr int SPARE = 16;    // inverse fraction by which a list may grow without being copied
  struct Run {
    int from, to, n;
  };
  int n_before_, n_after_;
  std::vector<Run> runs_;    // in ascending order in both lists
  std::vector<std::pair<int, int>> scattered_;

  void match(const PairRows &before, int first_before, int last_before, const PairRows &after, int first, int last);
  void match_row(const PairRows &before, int r_before, const PairRows &after, int r, bool one_kind);
  void search(const PairRows &before, const PairRows &after, int r, int k);
  bool search_rows(const PairRows &before, int first, int last, const PairRows &after, int r, int k);
  void add(int from, int to);

  template <class T> static typename std::vector<T>::iterator at(std::vector<T> &values, int k, int width)
  {
    return values.begin() + static_cast<std::ptrdiff_t>(k) * width;
  }

  /* Move a run, or all that follow it as long as they move backward in memory, the last of these first, so that none is overwritten
     before it has moved. Returns the next run. */
  template <class T> std::size_t move_stretch(std::vector<T> &values, std::size_t first, int width) const
  {
    std::size_t last = first;
    while (last < runs_.size() && runs_[last].to > runs_[last].from) last++;
    for (std::size_t n = last; n-- > first;) {
      const Run &run = runs_[n];
      std::copy_backward(at(values, run.from, width), at(values, run.from + run.n, width),
                         at(values, run.to + run.n, width));
    }
    if (last > first) return last;
    const Run &run = runs_[first];
    if (run.to != run.from)
      std::copy(at(values, run.from, width), at(values, run.from + run.n, width), at(values, run.to, width));
    return first + 1;
  }
};

}    // namespace granwave

#endif
