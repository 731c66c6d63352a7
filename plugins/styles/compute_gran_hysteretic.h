// SPDX-License-Identifier: GPL-2.0-only
/* Computes of pair style gran/hysteretic:

   compute ID group gran/hysteretic/atom            per sphere
   compute ID group gran/hysteretic/local           per contact, forgotten dents included
   compute ID group gran/hysteretic/contact I J     the contact of two spheres, as a global vector
   compute ID group gran/hysteretic/energy          of all contacts: a global scalar and vector, summed when asked for  */

#ifndef LMP_COMPUTE_GRAN_HYSTERETIC_H
#define LMP_COMPUTE_GRAN_HYSTERETIC_H

#include "compute.h"

#include <vector>

namespace LAMMPS_NS {

class PairGranHysteretic;

class ComputeGranHysteretic : public Compute {
 public:
  ComputeGranHysteretic(LAMMPS *, int, char **);
  void init() override;

 protected:
  PairGranHysteretic *pair = nullptr;
};

class ComputeGranHystereticAtom : public ComputeGranHysteretic {
 public:
  static constexpr const char *STYLE = "gran/hysteretic/atom";
  ComputeGranHystereticAtom(LAMMPS *, int, char **);
  ~ComputeGranHystereticAtom() override;
  void compute_peratom() override;
  double memory_usage() override;

 private:
  int nmax = 0;
};

class ComputeGranHystereticLocal : public ComputeGranHysteretic {
 public:
  static constexpr const char *STYLE = "gran/hysteretic/local";
  ComputeGranHystereticLocal(LAMMPS *, int, char **);
  void compute_local() override;
  double memory_usage() override;

 private:
  std::vector<double> values;
  std::vector<double *> rows;
};

class ComputeGranHystereticContact : public ComputeGranHysteretic {
 public:
  static constexpr const char *STYLE = "gran/hysteretic/contact";
  ComputeGranHystereticContact(LAMMPS *, int, char **);
  ~ComputeGranHystereticContact() override;
  void compute_vector() override;

 private:
  tagint first, second;
};

/* Energies of compute pair, summed only when asked for. LAMMPS flags a compute of its own at every step at which any
   fix with averages is due, so that the pair style has to sum up energies that nobody reads. */
class ComputeGranHystereticEnergy : public ComputeGranHysteretic {
 public:
  static constexpr const char *STYLE = "gran/hysteretic/energy";
  ComputeGranHystereticEnergy(LAMMPS *, int, char **);
  ~ComputeGranHystereticEnergy() override;
  double compute_scalar() override;
  void compute_vector() override;

 private:
  void sum_up();
  bigint summed = -1;    // step
};

}    // namespace LAMMPS_NS

#endif
