// SPDX-License-Identifier: GPL-2.0-only
/* Computes of pair style gran/hysteretic:

   compute ID group gran/hysteretic/atom            per sphere
   compute ID group gran/hysteretic/local           per contact, including forgotten dents
   compute ID group gran/hysteretic/contact I J     contact of two spheres, as a global vector
   compute ID group gran/hysteretic/energy          energies of all contacts: a global scalar and vector, summed on demand  */

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

/* Energies of compute pair, summed only when accessed. LAMMPS requests the tally of energies on every timestep on which an
   averaging fix is evaluated, even if they are not used. */
class ComputeGranHystereticEnergy : public ComputeGranHysteretic {
 public:
  static constexpr const char *STYLE = "gran/hysteretic/energy";
  ComputeGranHystereticEnergy(LAMMPS *, int, char **);
  ~ComputeGranHystereticEnergy() override;
  double compute_scalar() override;
  void compute_vector() override;

 private:
  void sum_up();
  bigint summed = -1;    // timestep of the last sum
};

}    // namespace LAMMPS_NS

#endif
