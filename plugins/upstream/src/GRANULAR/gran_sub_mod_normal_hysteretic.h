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

#ifdef GRAN_SUB_MOD_CLASS
// clang-format off
GranSubModStyle(hysteretic,GranSubModNormalHysteretic,NORMAL);
// clang-format on
#else

#ifndef GRAN_SUB_MOD_NORMAL_HYSTERETIC_H
#define GRAN_SUB_MOD_NORMAL_HYSTERETIC_H

#include "gran_sub_mod.h"
#include "gran_sub_mod_normal.h"

namespace LAMMPS_NS {
namespace Granular_NS {

class GranSubModNormalHysteretic : public GranSubModNormal {
 public:
  GranSubModNormalHysteretic(class GranularModel *, class LAMMPS *);
  void coeffs_to_local() override;
  void mix_coeffs(double *, double *) override;
  void init() override;
  bool touch() override;
  double pulloff_distance(double, double) override;
  double calculate_contact_radius() override;
  double calculate_forces() override;

 protected:
  double gap;              // largest gap at which a contact keeps its history
  double Emix;             // effective modulus
  double overlap_yield;    // overlap at first yield / effective radius
  double force_yield;      // force at first yield / effective radius squared
  double amplitude, pressure_yield, area_exponent;
  double peak_lossy;    // overlap from which on the unloading exponent is constant
  double Fne;

  // functions of a = overlap / overlap at first yield, for a > 1

  double pressure(double) const;
  double area(double) const;
  double force_loading(double) const;
  double work_loading(double) const;
  double residual(double) const;
  double energy_ratio(double) const;
  double exponent(double) const;

  double separate();
};

}    // namespace Granular_NS
}    // namespace LAMMPS_NS

#endif
#endif
