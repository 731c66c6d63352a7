// SPDX-License-Identifier: GPL-2.0-only
/* compute ID group gran/hysteretic/sums: per sphere, the sums of the magnitudes of the components of its contact forces, those of
   walls included. */

#ifndef LMP_COMPUTE_GRAN_HYSTERETIC_SUMS_H
#define LMP_COMPUTE_GRAN_HYSTERETIC_SUMS_H

#include "compute_gran_hysteretic.h"

namespace LAMMPS_NS {

class ComputeGranHystereticSums : public ComputeGranHysteretic {
 public:
  static constexpr const char *STYLE = "gran/hysteretic/sums";
  ComputeGranHystereticSums(LAMMPS *, int, char **);
  ~ComputeGranHystereticSums() override;
  void compute_peratom() override;
  double memory_usage() override;

 private:
  int nmax = 0;
};

}    // namespace LAMMPS_NS

#endif
