// SPDX-License-Identifier: GPL-2.0-only
/* Flat list of the pairs of pair style gran/hysteretic that are within reach, and what each remembers, from one reneighboring to the
   next. Meanwhile its contents are stored with the spheres (contact_history.h). */

#ifndef GRANWAVE_CONTACT_LIST_H
#define GRANWAVE_CONTACT_LIST_H

#include "../laws/contact_history.h"
#include "../laws/contact_memory.h"
#include "../laws/touching_pairs.h"
#include "lmptype.h"

namespace granwave {

/* Pairs within reach, in rows of the spheres with the lower ID (add_rows); behind them, in rows of their own, the special pairs. */
class ContactList {
 public:
  using tagint = LAMMPS_NS::tagint;
  struct Sphere {
    double radius;
    tagint tag;
    int type;
    std::int64_t birth;    // contact_history.h
  };

  explicit ContactList(ContactMemory &memory) : has(memory) {}

  bool valid = false, published = false;
  int plain = 0;                  // number of rows of pairs of spheres with laws that depend on their radii
  int owned = 0;                  // number of owned spheres when the list was built
  int most_pairs = 0;             // largest number of pairs of any of them
  std::vector<int> row, begin;    // sphere of each row, local or ghost; index of its first pair (one element longer)
  std::vector<int> partner;       // local or ghost index
  std::vector<double> peak;       // largest overlap so far
  std::vector<Front> front;       // of the largest overlap of this run
  std::vector<double> time_peak, time_yield;
  std::vector<int> turning;                // index into turnings, or -1 while Hertzian
  std::vector<Turning> turnings;           // of contacts that have yielded
  std::vector<double> work_lost;           // normalized dissipated energy at the turning point; -1 if not yet computed
  std::vector<double> circle;              // with friction: normalized area at the turning point
  std::vector<TangentialSpring> spring;    // with friction: force on the sphere of the row
  std::vector<std::uint64_t> touched;      // with friction or losses: bits of the pairs whose springs may end
  std::vector<double> initial, reached;    // with initial dents: initial dent, largest overlap of this run
  std::vector<double> initial_extra;       // with initial dents: initial doubles of the law
  std::vector<Sphere> row_sphere, partner_sphere;    // also after LAMMPS has put the atoms into another order
  /* Histories at the start of a minimization, which every evaluation in it continues from: a position that it tries and does not keep
     leaves no dent. */
  struct Start {
    bool kept = false;
    std::vector<Front> front;
    std::vector<double> peak, time_peak, time_yield, reached, extra;
  };
  Start start;
  RestingBlocks resting;
  RowGroups groups;                   // of the plain rows
  std::vector<char> quiet_special;    // 1 for special rows in which no pair touched at the last evaluation

  /* Make a list of these pairs of atoms, with contacts that have not touched. `sphere` returns an atom as a Sphere. */
  template <class AsSphere>
  void build(const std::vector<std::pair<int, int>> &plain_pairs, const std::vector<std::pair<int, int>> &special_pairs,
             const tagint *tag, int nlocal, int nall, const AsSphere &sphere)
  {
    owned = nlocal;
    row.clear();
    begin.assign(1, 0);
    partner.clear();
    add_rows(plain_pairs, tag, nall);
    plain = static_cast<int>(row.size());
    resting.build(row, begin, partner);
    groups.build(row, begin, partner, RestingBlocks::SIZE);
    add_rows(special_pairs, tag, nall);
    quiet_special.assign(row.size() - plain, 0);
    row_sphere.clear();
    for (const int i : row) row_sphere.push_back(sphere(i));
    partner_sphere.clear();
    for (const int j : partner) partner_sphere.push_back(sphere(j));
    clear_histories();
  }

  /* Call a function for each row r and pair k with the indices i and j of its spheres. */
  template <class Visit> void each_pair(const Visit &visit) const
  {
    for (int r = 0; r < static_cast<int>(row.size()); r++)
      for (int k = begin[r]; k < begin[r + 1]; k++) visit(r, k, row[r], partner[k]);
  }

  /* The same for each pair that has touched. */
  template <class Visit> void each_dent(const Visit &visit) const
  {
    constexpr int ROWS = RestingBlocks::SIZE;    // that are passed over at once
    const int rows = static_cast<int>(row.size());
    for (int first = 0; first < rows; first += ROWS) {
      const int last = first + ROWS < rows ? first + ROWS : rows;
      if (all_zero(peak.data() + begin[first], begin[last] - begin[first])) continue;
      for (int r = first; r < last; r++)
        for (int k = begin[r]; k < begin[r + 1]; k++)
          if (peak[k] != 0.0) visit(r, k, row[r], partner[k]);
    }
  }

  /* Return true if special row r need not be evaluated. */
  bool rests(int r) const
  {
    if (!quiet_special[r - plain] || resting.moved(row[r])) return false;
    const auto moved = [this](int j) { return resting.moved(j); };
    return std::none_of(partner.begin() + begin[r], partner.begin() + begin[r + 1], moved);
  }

  /* Have all rows evaluated next time, after a change of their history. */
  void disturb()
  {
    resting.disturb();
    std::fill(quiet_special.begin(), quiet_special.end(), 0);
  }

  /* Row and index of the pair of these IDs, the lower first; -1 if it is not in the list. Across a periodic boundary it may be
     twice in it, with the same history. */
  std::pair<int, int> find(tagint lower, tagint higher) const;

  /* History of pair k: its block, what its law needs, its dent, and all as seen from the sphere of the row. */
  double *block(int k) { return extra.data() + static_cast<std::size_t>(k) * has.n; }
  const double *block(int k) const { return extra.data() + static_cast<std::size_t>(k) * has.n; }
  LawHistory law_history(int k) const { return {peak[k], block(k)}; }
  Dent dent(int k) const { return {peak[k], front[k], time_peak[k], time_yield[k]}; }
  BlockView view(int k) const;

  /* Return true if something ends when pair k parts. */
  bool has_spring(int k) const
  {
    return (has.friction && spring[k].compliance > 0.0) || (has.loss && has.loss_of(block(k)).step > 0.0) ||
           (has.resistance && has.resistance_of(block(k)).active());
  }

  /* Index of the turning point of a contact that has yielded, which is recomputed if its history has changed since. */
  int cached_turning(int k, const ScaledLaw &contact)
  {
    if (turning[k] < 0 || turnings[turning[k]].peak < 0.0) renew_turning(k, contact);
    return turning[k];
  }
  /* Have the turning point of a contact recomputed when it is needed next. */
  void discard_turning(int k)
  {
    if (turning[k] >= 0) turnings[turning[k]].peak = -1.0;
  }

  /* Increase the largest overlap of this run, which may be smaller than the initial dent. */
  void raise_reached(int k, double overlap, double now, double step)
  {
    if (Front::crosses(reached[k], overlap)) front[k].rise(reached[k], overlap, now, step);
    reached[k] = overlap;
    time_peak[k] = now;
  }

  /* Keep the present histories as those at the start of a minimization, or return to those that were kept. */
  void keep_start();
  void return_to_start();

  /* Reset pair k to a contact that has not touched in this run, with this peak. With `dented` the peak is that of an initial dent,
     whose history is kept. */
  void reset(int k, double peak, bool dented);

  /* Set pair k to a contact that a file has whole; `yielded` if its peak is beyond the elastic limit. */
  void set(int k, const KnownContact &, bool yielded);

  /* Note which springs may end. */
  void find_springs();

  /* Write the block of pair k, as seen from the sphere of the row (side 1) or its partner (-1), into a zero block. */
  void pack(int k, double side, const BlockLayout &, double *block) const;

  /* Replace the live records of the owned spheres by the pairs that have touched. */
  void store(ContactHistory &);

  /* Take up the live records of the spheres. Those whose pair is no longer within reach are passed to a function, with the index
     of their sphere and of the record, and become those of forgotten contacts if it returns true; the others are dropped. */
  template <class Forget> void restore(ContactHistory &history, const Forget &forget)
  {
    each_pair([&](int r, int k, int i, int j) {
      take_up(history, k, i, partner_sphere[k], 1.0);
      take_up(history, k, j, row_sphere[r], -1.0);
    });
    history.each_record(owned, [&](int i, int m, ContactRecord &record) {
      if (record.live != FOUND) record.live = forget(i, m, record) ? 0 : FOUND;
    });
    history.keep_forgotten(owned, std::vector<int>(owned, 0));
  }

  double bytes() const;

 private:
  static constexpr int FOUND = 2;    // a live record that has been taken up

  ContactMemory &has;           // of the pair style
  std::vector<double> extra;    // blocks of has.n doubles

  void begin_anew(int k, double new_peak, bool dented);
  void keep_start_of(int k);
  void return_to_start_of(int k);
  void add_rows(const std::vector<std::pair<int, int>> &, const tagint *tag, int nall);
  void clear_histories();
  void renew_turning(int k, const ScaledLaw &);
  void take_up(ContactHistory &, int k, int of, const Sphere &partner, double side);
  void unpack(int k, double side, const BlockLayout &, const double *block);
};

}    // namespace granwave

#endif
