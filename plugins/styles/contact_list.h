// SPDX-License-Identifier: GPL-2.0-only
/* Flat list of the pairs of pair style gran/hysteretic that are within reach, and the history of each, from one
   reneighboring to the next. Histories stay in the list meanwhile; the next list copies them pair by pair. Only
   histories of migrating spheres and for restart files are stored with the spheres (contact_history.h). */

#ifndef GRANWAVE_CONTACT_LIST_H
#define GRANWAVE_CONTACT_LIST_H

#include "../kernels/contact_history.h"
#include "../kernels/contact_memory.h"
#include "../kernels/touching_pairs.h"
#include "pair_rows.h"

#include <functional>

namespace granwave {

class ContactList : public PairRows {
 public:
  explicit ContactList(ContactMemory &memory) : has(memory) {}

  bool valid = false;          // false if atoms may have been reordered: pairs then refer to the previous order
  bool published = false;      // true if the records of the spheres are up to date
  int most_pairs = 0;          // largest number of pairs of any owned sphere
  std::vector<double> peak;    // largest overlap so far
  std::vector<Front> front;    // arrival of the largest overlap of this run
  std::vector<double> time_peak, time_yield;
  std::vector<int> turning;                // index into turnings, or -1 while Hertzian
  std::vector<Turning> turnings;           // turning points of contacts that have yielded
  std::vector<double> work_lost;           // normalized dissipated energy at the turning point; -1 if not yet computed
  std::vector<double> circle;              // with friction: normalized area at the turning point
  std::vector<TangentialSpring> spring;    // with friction: force on the sphere of the row
  // with friction or losses: bits of the pairs whose springs may have to be ended
  std::vector<std::uint64_t> touched;
  std::vector<double> initial, reached;    // with initial dents: initial dent, largest overlap of this run
  std::vector<double> initial_extra;       // with initial dents: initial doubles of the law
  /* Histories at the start of a minimization, from which every evaluation in it continues: a trial position that is not kept
     leaves no dent. */
  struct Start {
    bool kept = false;
    std::vector<Front> front;
    std::vector<double> peak, time_peak, time_yield, reached, extra;
  };
  Start start;
  std::function<void()> bring_back;    // called before histories are read; set where they may be in the memory of a card
  RestingBlocks resting;
  RowGroups groups;                   // groups of the plain rows
  std::vector<char> quiet_special;    // 1 for special rows in which no pair touched at the last evaluation

  /* Make a list of these pairs of atoms. `sphere` returns an atom as a Sphere. Histories are those that the list before or else the
     live records of the spheres have. Where a pair is no longer within reach, a function is called with the index of each of its
     spheres that is still there, the record and its block, and the histories end. */
  template <class AsSphere, class Forget>
  void build(const std::vector<std::pair<int, int>> &plain_pairs, const std::vector<std::pair<int, int>> &special_pairs,
             const tagint *tag, int nlocal, int nall, const AsSphere &sphere, ContactHistory &history, const Forget &forget)
  {
    PairRows before;
    std::swap(before, static_cast<PairRows &>(*this));
    clear();
    owned = nlocal;
    add_rows(plain_pairs, tag, nall);
    plain = rows();
    resting.build(row, begin, partner);
    groups.build(row, begin, partner, RestingBlocks::SIZE);
    add_rows(special_pairs, tag, nall);
    quiet_special.assign(row.size() - plain, 0);
    spheres.reserve(nall);
    for (int i = 0; i < nall; i++) spheres.push_back(sphere(i));
    if (holds) carry_on(before, history, forget);
    else clear_histories();
    restore(history, forget);
    for (int i = 0; i < nlocal; i++) {
      history.own(i, tag[i]);
      history.list(i, i);
    }
    holds = valid = true;
    published = recorded = false;
    sides.clear();
  }

  /* Call a function for each pair that has touched, as each_pair. */
  template <class Visit> void each_dent(const Visit &visit) const
  {
    if (bring_back) bring_back();
    constexpr int ROWS = RestingBlocks::SIZE;    // rows that are skipped at a time
    for (int first = 0; first < rows(); first += ROWS) {
      const int last = std::min(first + ROWS, rows());
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

  /* Mark all rows for the next evaluation, after a change of their history. */
  void disturb()
  {
    resting.disturb();
    std::fill(quiet_special.begin(), quiet_special.end(), 0);
  }

  /* History of pair k: its block, what its law needs, its dent, and all as seen from the sphere of the row. */
  double *block(int k) { return extra.data() + static_cast<std::size_t>(k) * has.n; }
  const double *block(int k) const { return extra.data() + static_cast<std::size_t>(k) * has.n; }
  LawHistory law_history(int k) const { return {peak[k], block(k)}; }
  Dent dent(int k) const { return {peak[k], front[k], time_peak[k], time_yield[k]}; }
  BlockView view(int k) const;

  /* Return true if a spring or force ends when pair k separates. */
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
  /* Mark the turning point of a contact for recomputation. */
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

  /* Set pair k to a complete contact of a file; `yielded` if its peak is beyond the elastic limit. */
  void set(int k, const KnownContact &, bool yielded);

  /* Have all turning points recomputed when they are needed next, after a change of laws or radii. */
  void discard_turnings();

  /* Record the springs that may end. */
  void find_springs();

  /* Write the block of pair k, as seen from the sphere of the row (side 1) or its partner (-1), into a zero block. */
  void pack(int k, double side, const BlockLayout &, double *block) const;

  /* Records of the spheres, while the list is valid or atoms are put into another order. */

  /* Make the list invalid. It keeps the histories of its pairs. */
  void suspend(ContactHistory &);

  /* Write the pairs of all spheres that have touched to their records; histories stay in the list if the list is valid. */
  void publish(ContactHistory &, int nlocal);

  /* Move the pairs of sphere i that have touched to its records: it leaves the processor. */
  void hand_over(ContactHistory &, int i);

  /* Move all pairs, so that the next list begins with the records. */
  void release(ContactHistory &, int nlocal);

  /* Return true if a pair of sphere i, of an invalid list, has touched. */
  bool has_touched(const ContactHistory &, int i);

  double bytes() const;

 private:
  static constexpr int FOUND = 2;     // a live record that has been transferred to the list
  static constexpr int UNUSED = 2;    // turning points are sorted if their number exceeds this multiple of those in use

  struct Side {    // contact of a sphere
    int row, pair;
  };
  struct Sides {    // contacts that have touched, by owned sphere, in the order of the list
    std::vector<int> first;
    std::vector<Side> all;
    void clear() { *this = {}; }
  };

  ContactMemory &has;           // memory of the contacts of the pair style
  std::vector<double> extra;    // blocks of has.n doubles
  bool holds = false;           // true if the list, not the spheres, has the histories
  bool recorded = false;        // true if live records of its spheres have been written
  Sides sides;                  // empty until needed

  void begin_anew(int k, double new_peak, bool dented);
  void keep_start_of(int k);
  void return_to_start_of(int k);
  void clear_histories();
  void renew_turning(int k, const ScaledLaw &);
  void order_turnings();
  void take_up(ContactHistory &, int k, int of, const Sphere &partner, double side);
  void unpack(int k, double side, const BlockLayout &, const double *block);
  ContactRecord record_of(int k, const Sphere &other) const
  {
    return {other.tag, other.birth, other.radius, other.type, 1, dent(k)};
  }
  void drop_records(ContactHistory &);
  void find_sides();
  void append_records(ContactHistory &, int i, int listed);
  void carry(const CommonPairs &);

  /* Take over the histories of the pairs of the previous list, whose rows are given. */
  template <class Forget> void carry_on(const PairRows &before, ContactHistory &history, const Forget &forget)
  {
    const CommonPairs common(before, *this);
    start.kept = false;
    forget_others(common, before, history, forget);
    struct Kept {
      int k;
      Dent dent;
    };
    const BlockLayout layout = history.layout();
    const std::size_t size = layout.size();
    std::vector<Kept> kept;
    std::vector<double> blocks(size * common.scattered().size(), 0.0);
    for (const auto &[from, to] : common.scattered()) {
      if (peak[from] == 0.0) continue;
      pack(from, 1.0, layout, blocks.data() + size * kept.size());
      kept.push_back({to, dent(from)});
    }
    carry(common);
    for (std::size_t n = 0; n < kept.size(); n++)
      set_history(kept[n].k, 1.0, layout, kept[n].dent, blocks.data() + size * n);
    order_turnings();
  }

  /* End the histories of pairs of the previous list that are no longer within reach. */
  template <class Forget>
  void forget_others(const CommonPairs &common, const PairRows &before, const ContactHistory &history, const Forget &forget)
  {
    std::vector<int> now;    // index of each sphere of the previous list, -1 if it has left
    const BlockLayout layout = history.layout();
    std::vector<double> block(layout.size());
    common.each_left_out(before, [&](int r, int k) {
      if (peak[k] == 0.0) return;
      const Sphere &lower = before.sphere_of_row(r), &higher = before.partner_of_pair(k);
      if (find(lower, higher) >= 0) return;
      if (now.empty()) {
        now.assign(before.owned, -1);
        for (int i = 0; i < owned; i++)
          if (history.listed(i) >= 0) now[history.listed(i)] = i;
      }
      const auto end = [&](int of, const Sphere &other, double side) {
        if (of >= before.owned || now[of] < 0) return;
        pack(k, side, layout, block.data());
        forget(now[of], record_of(k, other), block.data());
      };
      end(before.row[r], higher, 1.0);
      end(before.partner[k], lower, -1.0);
    });
  }

  void set_history(int k, double side, const BlockLayout &layout, const Dent &dent, const double *block)
  {
    unpack(k, side, layout, block);
    peak[k] = dent.peak;
    front[k] = dent.front;
    time_peak[k] = dent.time_peak;
    time_yield[k] = dent.time_yield;
    turning[k] = -1;
  }

  /* Copy the live records of the spheres to the list. Records whose pair is not within reach are passed to `forget`. */
  template <class Forget> void restore(ContactHistory &history, const Forget &forget)
  {
    if (history.size() == 0) return;
    each_pair([&](int r, int k, int i, int j) {
      take_up(history, k, i, partner_of_pair(k), 1.0);
      take_up(history, k, j, sphere_of_row(r), -1.0);
    });
    struct Ended {
      int sphere;
      ContactRecord record;
      std::vector<double> block;
    };
    std::vector<Ended> ended;
    const int size = history.layout().size();
    history.each_record(owned, [&](int i, int m, const ContactRecord &record) {
      if (record.live && record.live != FOUND)
        ended.push_back({i, record, std::vector<double>(history.block(i, m), history.block(i, m) + size)});
    });
    history.keep_forgotten(owned);
    for (const Ended &end : ended) forget(end.sphere, end.record, end.block.data());
  }
};

}    // namespace granwave

#endif
