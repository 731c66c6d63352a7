// SPDX-License-Identifier: GPL-2.0-only
/* Computes of pair style gran/hysteretic:

   compute ID group gran/hysteretic/atom            per sphere
   compute ID group gran/hysteretic/local           per contact, including forgotten dents
   compute ID group gran/hysteretic/contact I J     contact of two spheres, as a global vector
   compute ID group gran/hysteretic/energy          energies of all contacts: a global scalar and vector, summed on demand
   compute ID group gran/hysteretic/sums            per sphere, the sums of the magnitudes of the components of its contact
                                                    forces, those of walls included  */

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(gran/hysteretic/atom,ComputeGranHystereticAtom);
ComputeStyle(gran/hysteretic/contact,ComputeGranHystereticContact);
ComputeStyle(gran/hysteretic/energy,ComputeGranHystereticEnergy);
ComputeStyle(gran/hysteretic/local,ComputeGranHystereticLocal);
ComputeStyle(gran/hysteretic/sums,ComputeGranHystereticSums);
// clang-format on
#else

#ifndef LMP_COMPUTE_GRAN_HYSTERETIC_H
#define LMP_COMPUTE_GRAN_HYSTERETIC_H

#include "compute.h"

#include <vector>

namespace LAMMPS_NS {

class PairGranHysteretic;

class ComputeGranHysteretic : public Compute {
 public:
  ComputeGranHysteretic(LAMMPS *, int, char **, int words = 0, const char *expected = "it takes no arguments");
  ~ComputeGranHysteretic() override;
  void init() override;
  double memory_usage() override { return double(nmax) * size_peratom_cols * sizeof(double); }

 protected:
  void start_atoms();    // with zeros
  void finish_atoms();

  PairGranHysteretic *pair = nullptr;
  int nmax = 0;
};

class ComputeGranHystereticAtom : public ComputeGranHysteretic {
 public:
  static constexpr const char *STYLE = "gran/hysteretic/atom";
  ComputeGranHystereticAtom(LAMMPS *, int, char **);
  void compute_peratom() override;
};

class ComputeGranHystereticSums : public ComputeGranHysteretic {
 public:
  static constexpr const char *STYLE = "gran/hysteretic/sums";
  ComputeGranHystereticSums(LAMMPS *, int, char **);
  void compute_peratom() override;
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
  void init() override
  {
    ComputeGranHysteretic::init();
    summed = -1;    // spheres and laws may have changed since the last run
  }
  double compute_scalar() override;
  void compute_vector() override;

 private:
  void sum_up();
  bigint summed = -1;    // timestep of the last sum
};

}    // namespace LAMMPS_NS

#endif

#endif
