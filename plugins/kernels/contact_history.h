// SPDX-License-Identifier: GPL-2.0-only
/* Contact history by sphere: one record per contact of a sphere. The contact is live if the pair is within reach, otherwise
   its history has been discarded. What the energies need of forgotten contacts is in sums by sphere, or their records are kept.
   No LAMMPS types.

   Records of one sphere are contiguous in a pool, so that moving a sphere within the processor moves two numbers. A record
   consists of the quantities common to all contacts and a block of doubles that is copied as a whole: history variables of
   the law, of friction and of initial dents. Without these, and with laws that need only the largest overlap, the block is
   empty. */

#ifndef GRANWAVE_CONTACT_HISTORY_H
#define GRANWAVE_CONTACT_HISTORY_H

#include "../laws/tangential.h"
#include "front.h"
#include "stored.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace granwave {

/* Largest overlap of a contact, in length units, and its times; -1 = never. */
struct Dent {
  double peak = 0.0;
  Front front;    // of the overlap
  double time_peak = -1.0, time_yield = -1.0;
};

/* Replace a time by another time if that is earlier; -1 = never. */
inline void earliest(double &time, double other)
{
  if (other >= 0.0 && (time < 0.0 || other < time)) time = other;
}

struct ContactRecord {
  static constexpr int SIZE = 10;    // number of doubles in messages and restart files, which contain it unchanged

  std::int64_t partner;          // ID of the other sphere
  std::int64_t partner_birth;    // and its birth number, because another sphere may reuse the ID of a deleted one
  double partner_radius;
  std::int32_t partner_type;
  std::int32_t live;
  Dent dent;
};
static_assert(doubles_of<ContactRecord>() == ContactRecord::SIZE);

/* Sums over the forgotten contacts of a sphere; all members are doubles, for communication. */
struct ForgottenContacts {
  double dissipated = 0.0, frictional_loss = 0.0, viscous_loss = 0.0;    // by whole contacts
  double own_dissipated = 0.0;                                           // this sphere's part
  double yielded = 0.0, beyond_half = 0.0, beyond_law = 0.0;             // numbers of contacts
  double peak_force = 0.0, peak_overlap = 0.0;
  double time_first = -1.0, time_peak = -1.0, time_yield = -1.0;    // time_peak: time of the largest force; -1 = never
  double rolling_loss = 0.0, twisting_loss = 0.0;                   // part of frictional_loss
  // energy lost where surfaces snapped into contact and separated
  double adhesive_loss = 0.0;

  static constexpr int SIZE = 15;

  bool none() const { return peak_overlap == 0.0; }
};
static_assert(doubles_of<ForgottenContacts>() == ForgottenContacts::SIZE);

/* Layout of the block of a record: doubles of the law; with friction the spring; with initial dents the initial dent, the
   largest overlap of this run, and the initial doubles of the law. */
struct BlockLayout {
  static constexpr int N_SPRING = doubles_of<TangentialSpring>();
  static constexpr int N_DENT = 2;

  int n_extra = 0;    // doubles of the law; the largest number if there are several laws
  bool friction = false, dents = false;

  int spring() const { return n_extra; }
  int initial() const { return spring() + (friction ? N_SPRING : 0); }
  int initial_extra() const { return initial() + N_DENT; }
  int size() const { return initial() + (dents ? N_DENT + n_extra : 0); }

  /* Return the smallest layout that contains both. */
  BlockLayout with(const BlockLayout &other) const
  {
    return {std::max(n_extra, other.n_extra), friction || other.friction, dents || other.dents};
  }
  bool operator!=(const BlockLayout &other) const
  {
    return n_extra != other.n_extra || friction != other.friction || dents != other.dents;
  }
};

/* Components of a block; without friction or initial dents they have their initial values. */
struct BlockView {
  BlockView(const BlockLayout &layout, const double *block) : extra(block)
  {
    if (layout.friction) spring = from_doubles<TangentialSpring>(block + layout.spring());
    if (!layout.dents) return;
    initial = block[layout.initial()];
    reached = block[layout.initial() + 1];
    initial_extra = block + layout.initial_extra();
  }
  BlockView() = default;

  TangentialSpring spring;
  double initial = 0.0, reached = 0.0;    // initial dent, largest overlap of this run
  const double *extra = nullptr, *initial_extra = nullptr;
  double side = 1.0;    // -1: the spring is seen from the second sphere; vectors in `extra` are not
};

class ContactHistory {
 public:
  const BlockLayout &layout() const { return layout_; }

  /* Extend all blocks to this layout, keeping their contents. */
  void extend(const BlockLayout &other)
  {
    const BlockLayout wanted = layout_.with(other);
    if (!(wanted != layout_)) return;
    const int before = layout_.size(), after = wanted.size();
    std::vector<double> fresh(pool_.size() * after, 0.0);
    for (std::size_t k = 0; k < pool_.size(); k++)
      copy_block(layout_, blocks_.data() + k * before, wanted, fresh.data() + k * after);
    blocks_.swap(fresh);
    layout_ = wanted;
  }

  /* Copy a block into a block of zeros of another layout that contains its layout. */
  static void copy_block(const BlockLayout &from, const double *source, const BlockLayout &to, double *target)
  {
    const int n = std::min(from.n_extra, to.n_extra);
    std::copy_n(source, n, target);
    if (from.friction) std::copy_n(source + from.spring(), static_cast<int>(BlockLayout::N_SPRING), target + to.spring());
    if (!from.dents) return;
    std::copy_n(source + from.initial(), static_cast<int>(BlockLayout::N_DENT), target + to.initial());
    std::copy_n(source + from.initial_extra(), n, target + to.initial_extra());
  }

  void grow(int n)
  {
    first_.resize(n, 0);
    count_.resize(n, 0);
    listed_.resize(n, -1);
    owner_.resize(n, 0);
    birth_.resize(n, 0);
    if (!forgotten_.empty()) forgotten_.resize(n);
  }

  /* Sums over the forgotten contacts of sphere i, to be read or added to. */
  ForgottenContacts forgotten(int i) const { return forgotten_.empty() ? ForgottenContacts() : forgotten_[i]; }
  ForgottenContacts &forgotten_to_change(int i)
  {
    if (forgotten_.empty()) forgotten_.resize(count_.size());
    return forgotten_[i];
  }

  /* Set the ID of the sphere that the records belong to, by which a later change of its ID is detected. */
  void own(int i, std::int64_t id) { owner_[i] = id; }
  std::int64_t owner(int i) const { return owner_[i]; }

  /* Set and return the index that sphere i had when the flat list of the pair style was built; -1 if it came later. */
  void list(int i, int index) { listed_[i] = index; }
  int listed(int i) const { return listed_[i]; }

  /* Unique number of sphere i, owned or ghost, among all spheres that have or had its ID. */
  std::int64_t birth(int i) const { return birth_[i]; }
  void set_birth(int i, std::int64_t number) { birth_[i] = number; }

  int count(int i) const { return count_[i]; }
  ContactRecord *records(int i) { return pool_.data() + first_[i]; }
  const ContactRecord *records(int i) const { return pool_.data() + first_[i]; }
  /* Block of record m of sphere i. */
  const double *block(int i, int m) const { return blocks_.data() + (first_[i] + m) * layout_.size(); }

  void forget_sphere(int i)
  {
    count_[i] = 0;
    if (!forgotten_.empty()) forgotten_[i] = {};
  }
  void copy(int from, int to)
  {
    first_[to] = first_[from];
    count_[to] = count_[from];
    listed_[to] = listed_[from];
    owner_[to] = owner_[from];
    birth_[to] = birth_[from];
    if (!forgotten_.empty()) forgotten_[to] = forgotten_[from];
  }

  /* Append to the records of sphere i, which are moved to the end of the pool unless they are there already. The block must
     not be part of the pool. */
  void append(int i, const ContactRecord &record, const double *block)
  {
    if (count_[i] == 0) {
      first_[i] = pool_.size();
    } else if (first_[i] + count_[i] != pool_.size()) {
      const std::size_t from = first_[i], size = layout_.size();
      first_[i] = pool_.size();
      pool_.resize(pool_.size() + count_[i]);
      std::copy_n(pool_.data() + from, count_[i], pool_.data() + first_[i]);
      blocks_.resize(pool_.size() * size);
      std::copy_n(blocks_.data() + from * size, count_[i] * size, blocks_.data() + first_[i] * size);
    }
    pool_.push_back(record);
    blocks_.insert(blocks_.end(), block, block + layout_.size());
    count_[i]++;
  }

  /* Keep only the records of spheres i < n that are not live. */
  void keep_forgotten(int n)
  {
    const std::size_t size = layout_.size();
    std::vector<ContactRecord> kept;
    std::vector<double> kept_blocks;
    kept.reserve(std::count_if(pool_.begin(), pool_.end(), is_forgotten));
    kept_blocks.reserve(kept.capacity() * size);
    for (int i = 0; i < n; i++) {
      const std::size_t at = kept.size();
      for (std::size_t k = first_[i]; k < first_[i] + count_[i]; k++) {
        if (!is_forgotten(pool_[k])) continue;
        kept.push_back(pool_[k]);
        kept_blocks.insert(kept_blocks.end(), blocks_.data() + k * size, blocks_.data() + (k + 1) * size);
      }
      first_[i] = at;
      count_[i] = static_cast<int>(kept.size() - at);
    }
    pool_.swap(kept);
    blocks_.swap(kept_blocks);
  }

  /* Call a function for each record m of the spheres i < n. */
  template <class Visit> void each_record(int n, const Visit &visit)
  {
    for (int i = 0; i < n && !pool_.empty(); i++)
      for (int m = 0; m < count_[i]; m++) visit(i, m, pool_[first_[i] + m]);
  }

  std::size_t size() const { return pool_.size(); }
  bool has_forgotten() const { return !forgotten_.empty(); }
  bool has_forgotten(int i) const { return !forgotten_.empty() && !forgotten_[i].none(); }
  double memory_usage() const
  {
    return static_cast<double>(pool_.capacity() * sizeof(ContactRecord) + blocks_.capacity() * sizeof(double) +
                               first_.capacity() * sizeof(std::size_t) +
                               count_.capacity() * (2 * sizeof(int) + 2 * sizeof(std::int64_t)) +
                               forgotten_.capacity() * sizeof(ForgottenContacts));
  }

 private:
  BlockLayout layout_;
  std::vector<std::size_t> first_;
  std::vector<int> count_, listed_;
  std::vector<std::int64_t> owner_, birth_;
  std::vector<ForgottenContacts> forgotten_;    // by sphere; empty if there are none
  std::vector<ContactRecord> pool_;
  std::vector<double> blocks_;    // layout_.size() doubles per record

  static bool is_forgotten(const ContactRecord &record) { return !record.live; }
};

}    // namespace granwave

#endif
