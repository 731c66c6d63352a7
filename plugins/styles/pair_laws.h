// SPDX-License-Identifier: GPL-2.0-only
/* Contact laws of pair style gran/hysteretic by pair of types, and in physical units for two bodies with their radii.

   Pairs of types are special if their force does not depend on the radii alone, or acts at a distance: those of cylinders, those with
   cohesion, those whose force is a power of the overlap. */

#ifndef GRANWAVE_PAIR_LAWS_H
#define GRANWAVE_PAIR_LAWS_H

#include "../laws/law_arguments.h"
#include "fix_gran_cylinder.h"

#include <map>
#include <memory>
#include <tuple>
#include <vector>

namespace granwave {

/* Parameters of a contact, from its two bodies. */
struct PairParameters {
  double radius_i, radius_j, radsum, touch_sq, largest_overlap;
  double root_radius;    // square root of R*
  ScaledLaw contact;
  double friction;           // 0 if one of the two is a face
  double shear_stiffness;    // 8 G*
  TangentialModel tangential_model = TangentialModel::MINDLIN_RESCALE;
  ViscousLoss loss;
  const ResistanceModel *resistance = nullptr;    // to rolling and twisting, null if there is none
};

class PairLaws {
 public:
  explicit PairLaws(LAMMPS_NS::LAMMPS *lmp) : lmp_(lmp) {}

  /* Effective radius of two spheres, or of a sphere and a flat face (radius 0). */
  static double effective_radius(double ri, double rj) { return ri > 0.0 && rj > 0.0 ? ri * rj / (ri + rj) : ri + rj; }

  /* Overlap above which an error is raised: the center of a sphere is then near the other surface or face. */
  static double largest_overlap(double ri, double rj)
  {
    return ri > 0.0 && rj > 0.0 ? (ri < rj ? ri : rj) : 0.5 * (ri + rj);
  }

  void allocate(int types);
  int types() const { return types_; }
  /* Arguments of pair_coeff, for mixing and restarts; also those of the second type before the first, once `make` was called. */
  LawArguments &arguments(int i, int j) { return arguments_[at(i, j)]; }
  /* Make the laws of types i and j from their arguments; the first material is the material of type i. */
  void make(int i, int j);
  const ContactLaw &law(int i, int j) const { return laws_[at(i, j)]; }

  /* Begin a run with these cylinders, null if there are none. No pair of types is special. */
  void begin_run(std::shared_ptr<const Cylinders>);
  const Cylinders *cylinders() const { return cylinders_.get(); }
  /* Return true if one of these types is a cylinder. */
  bool shaped(int i, int j) const
  {
    return cylinders_ && !(cylinders_->shape(i).is_sphere() && cylinders_->shape(j).is_sphere());
  }
  void make_special(int i, int j);
  bool is_special(int i, int j) const { return has_special_ && special_[at(i, j)]; }
  /* Kind of contact of two types, one of which is a cylinder; null for spheres. */
  const CylinderPair *geometry(int i, int j) const { return geometries_[at(i, j)].get(); }

  /* Law of two bodies of these types and radii. */
  ScaledLaw scaled(int i, int j, double ri, double rj)
  {
    if (is_special(i, j)) return special_law(i, j, ri, rj);
    return {law(i, j), effective_radius(ri, rj), ri, rj};
  }
  PairParameters parameters(int i, int j, double ri, double rj);

  /* Table of the parameters by pair of types, if all bodies of a type are equal. */
  bool has_table() const { return !table_.empty(); }
  const PairParameters &from_table(int i, int j) const { return table_[at(i, j)]; }
  /* Fill the table from the radius of each type, below 0 if there is no body of it. */
  void fill_table(const std::vector<double> &radius);
  void discard_table() { table_.clear(); }

 private:
  struct SpecialPair {
    std::unique_ptr<ElasticContact> line;    // of parallel cylinders
    ScaledLaw contact;
  };

  std::size_t at(int i, int j) const { return static_cast<std::size_t>(i) * (types_ + 1) + j; }
  ScaledLaw special_law(int i, int j, double ri, double rj);

  LAMMPS_NS::LAMMPS *lmp_;
  int types_ = 0;
  std::vector<ContactLaw> laws_;
  std::vector<LawArguments> arguments_;
  std::shared_ptr<const Cylinders> cylinders_;
  bool has_special_ = false;
  std::vector<char> special_;
  std::vector<std::unique_ptr<CylinderPair>> geometries_;
  std::map<std::tuple<int, int, double, double>, SpecialPair> special_pairs_;
  std::vector<PairParameters> table_;
};

}    // namespace granwave

#endif
