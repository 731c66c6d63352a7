/* The memory of contacts by sphere: one record for each dent that a sphere shares with another, whether the pair is
   close now (live) or has parted for good (forgotten; kept for the ledger only). No LAMMPS types.

   Records of one sphere are contiguous in a pool, so that moving a sphere within the processor moves two numbers. What only
   friction and dents of earlier runs need lies in a second pool beside it, which is empty until widen(). */

#ifndef GRANWAVE_CONTACT_HISTORY_H
#define GRANWAVE_CONTACT_HISTORY_H

#include "tangential.h"

#include <cstdint>
#include <vector>

namespace granwave {

/* What a contact remembers. Overlap in length units; times in time units, -1 = never. */
struct Dent {
  double peak = 0.0;    // largest overlap ever: the only variable of the law
  double time_first = -1.0, time_peak = -1.0, time_yield = -1.0;
};

struct DentRecord {
  static constexpr int SIZE = 8;    // as doubles, in messages and restart files

  std::int64_t partner;    // id of the other sphere
  double partner_radius;
  std::int32_t partner_type;
  std::int32_t live;
  Dent dent;
};

/* The rest of it, where there is friction or a past. */
struct ContactPast {
  static constexpr int SIZE = 7;    // as doubles

  Spring spring;
  double initial = 0.0;    // the dent before this run
  double reached = 0.0;    // largest overlap of this run
};

class ContactHistory {
 public:
  bool wide() const { return wide_; }
  void widen()
  {
    wide_ = true;
    pasts_.resize(pool_.size());
  }

  void grow(int n)
  {
    first_.resize(n, 0);
    count_.resize(n, 0);
    owner_.resize(n, 0);
  }

  /* Whose records these are: a sphere that was given another id since cannot be told from a stranger. */
  void own(int i, std::int64_t id) { owner_[i] = id; }
  std::int64_t owner(int i) const { return owner_[i]; }

  int count(int i) const { return count_[i]; }
  DentRecord *records(int i) { return pool_.data() + first_[i]; }
  const DentRecord *records(int i) const { return pool_.data() + first_[i]; }
  ContactPast past(int i, int m) const { return wide_ ? pasts_[first_[i] + m] : ContactPast(); }    // of record m of sphere i

  void forget_sphere(int i) { count_[i] = 0; }
  void copy(int from, int to)
  {
    first_[to] = first_[from];
    count_[to] = count_[from];
    owner_[to] = owner_[from];
  }

  /* Append to the records of sphere i; they move to the end of the pool unless they lie there already. */
  void append(int i, const DentRecord &record, const ContactPast &past)
  {
    if (count_[i] == 0) {
      first_[i] = pool_.size();
    } else if (first_[i] + count_[i] != pool_.size()) {
      const std::size_t from = first_[i];
      first_[i] = pool_.size();
      for (int k = 0; k < count_[i]; k++) {
        const DentRecord moved = pool_[from + k];
        pool_.push_back(moved);
        if (!wide_) continue;
        const ContactPast moved_past = pasts_[from + k];
        pasts_.push_back(moved_past);
      }
    }
    pool_.push_back(record);
    if (wide_) pasts_.push_back(past);
    count_[i]++;
  }

  /* Start a new pool in which sphere i < n has room for extra[i] records behind those it keeps. */
  void reserve(int n, const std::vector<int> &extra)
  {
    std::vector<DentRecord> fresh;
    std::vector<ContactPast> fresh_pasts;
    std::size_t total = 0;
    for (int i = 0; i < n; i++) total += count_[i] + extra[i];
    fresh.resize(total);
    if (wide_) fresh_pasts.resize(total);
    std::size_t at = 0;
    for (int i = 0; i < n; i++) {
      for (int k = 0; k < count_[i]; k++) {
        fresh[at + k] = pool_[first_[i] + k];
        if (wide_) fresh_pasts[at + k] = pasts_[first_[i] + k];
      }
      first_[i] = at;
      at += count_[i] + extra[i];
    }
    pool_.swap(fresh);
    pasts_.swap(fresh_pasts);
  }

  /* Fill the room made by reserve(). */
  void place(int i, const DentRecord &record, const ContactPast &past)
  {
    const std::size_t at = first_[i] + count_[i]++;
    pool_[at] = record;
    if (wide_) pasts_[at] = past;
  }

  /* Keep only the forgotten records of spheres i < n; gives the memory of the live ones back. */
  void keep_forgotten(int n)
  {
    std::vector<DentRecord> kept;
    std::vector<ContactPast> kept_pasts;
    for (int i = 0; i < n; i++) {
      const std::size_t at = kept.size();
      for (std::size_t k = first_[i]; k < first_[i] + count_[i]; k++) {
        if (pool_[k].live) continue;
        kept.push_back(pool_[k]);
        if (wide_) kept_pasts.push_back(pasts_[k]);
      }
      first_[i] = at;
      count_[i] = static_cast<int>(kept.size() - at);
    }
    pool_.swap(kept);
    pasts_.swap(kept_pasts);
  }

  std::size_t size() const { return pool_.size(); }
  double memory_usage() const
  {
    return static_cast<double>(pool_.capacity() * sizeof(DentRecord) + pasts_.capacity() * sizeof(ContactPast) +
                               first_.capacity() * sizeof(std::size_t) + count_.capacity() * (sizeof(int) + sizeof(std::int64_t)));
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<int> count_;
  std::vector<std::int64_t> owner_;
  std::vector<DentRecord> pool_;
  bool wide_ = false;
  std::vector<ContactPast> pasts_;    // as long as the pool, or empty
};

}    // namespace granwave

#endif
