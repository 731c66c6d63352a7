// SPDX-License-Identifier: GPL-2.0-only
/* Storage of the contact history of pair style gran/hysteretic with the spheres: through separation, reneighboring,
   migration between processors and restart. Created by the pair style with the fixed ID below, never by the user. */

#ifdef FIX_CLASS
// clang-format off
FixStyle(gran/hysteretic/history,FixGranHystereticHistory);
// clang-format on
#else

#ifndef LMP_FIX_GRAN_HYSTERETIC_HISTORY_H
#define LMP_FIX_GRAN_HYSTERETIC_HISTORY_H

#include "../kernels/contact_history.h"
#include "fix.h"

#include <functional>

namespace LAMMPS_NS {

class FixGranHystereticHistory : public Fix {
 public:
  static constexpr const char *STYLE = "gran/hysteretic/history";
  static constexpr const char *ID = "GRAN_HYSTERETIC_HISTORY";

  FixGranHystereticHistory(LAMMPS *, int, char **);
  ~FixGranHystereticHistory() override;

  int setmask() override { return FixConst::PRE_EXCHANGE | FixConst::MIN_PRE_EXCHANGE; }
  void setup_pre_exchange() override { gather(); }
  void pre_exchange() override { gather(); }
  void min_pre_exchange() override;

  void grow_arrays(int nmax) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_border(int, int *, double *) override;
  int unpack_border(int, int, double *) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  double memory_usage() override { return history.memory_usage(); }

  /* Reserve space for spheres with up to this number of further records, for commands that migrate
     spheres between two runs. */
  void expect_records(int n);
  /* Reserve space for sphere i, which has a further record. */
  void expect_records_of(int i) { maxexchange = std::max(maxexchange, size(i, in_list)); }

  /* Give the records of all processors the same layout. A collective call. */
  void agree_on_layout();

  granwave::ContactHistory history;

  /* Periodic images that a ghost is away from its sphere, along the edges of the box; 0 for an owned sphere. */
  struct Images {
    std::int8_t along[3] = {};
    bool none() const { return along[0] == 0 && along[1] == 0 && along[2] == 0; }
  };
  const Images &images(int i) const { return images_[i]; }

  /* Set by the pair style, whose flat list is more recent than the records: update these; be told that atoms may be put into another
     order, after which the list is not valid; be told that the fix is deleted by somebody else; undo what a minimization has tried. */
  std::function<void()> publish_contacts, suspend_contacts, lose_contacts, return_to_start;
  /* Set by the pair style too: update the records of a sphere that leaves. */
  std::function<void(int)> hand_over_contacts;

 private:
  static constexpr int RANKS = 24;      // bits of a birth number that identify the processor
  static constexpr int N_BORDER = 7;    // numbers of a ghost: birth, position of its sender and images of that

  std::int64_t births = 0;    // births on any processor so far, at least; earlier spheres are not counted
  std::vector<Images> images_;
  int in_list = 0;    // largest number of contacts of a sphere that are only in the list

  void gather();
  int most_numbers(int further) const;
  int size(int i, int further) const;
  int pack(int, double *) const;
  int unpack(int, const double *);
};

}    // namespace LAMMPS_NS

#endif

#endif
