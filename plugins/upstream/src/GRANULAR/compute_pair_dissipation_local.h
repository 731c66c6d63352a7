/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   Copyright (2003) Sandia Corporation.  Under the terms of Contract
   DE-AC04-94AL85000 with Sandia Corporation, the U.S. Government retains
   certain rights in this software.  This software is distributed under
   the GNU General Public License.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(pair/dissipation/local,ComputePairDissipationLocal);
// clang-format on
#else

#ifndef LMP_COMPUTE_PAIR_DISSIPATION_LOCAL_H
#define LMP_COMPUTE_PAIR_DISSIPATION_LOCAL_H

#include "compute.h"
#include "fix_pair_dissipation.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class ComputePairDissipationLocal : public Compute {
 public:
  ComputePairDissipationLocal(class LAMMPS *, int, char **);
  ~ComputePairDissipationLocal() override;
  void init() override;
  void compute_vector() override;
  void compute_local() override;
  double memory_usage() override;

 private:
  // one output value: IDs of the atoms, or energy or rate of one channel or all of them

  enum Quantity { TAG1, TAG2, ENERGY, RATE };
  struct Value {
    Quantity quantity;
    int channel;
  };
  std::vector<Value> values;

  std::string id_fix;
  FixPairDissipation *fix;
  int nmax;
  double *vlocal;
  double **alocal;

  double get(const Value &, tagint, const FixPairDissipation::Contact &) const;
  void reallocate(int);
};

}    // namespace LAMMPS_NS

#endif
#endif
