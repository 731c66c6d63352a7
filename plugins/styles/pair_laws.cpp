// SPDX-License-Identifier: GPL-2.0-only
#include "pair_laws.h"

#include "../kernels/touching_pairs.h"

#include "error.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

namespace granwave {

namespace {

constexpr double VALID = 0.2;    // largest overlap of a line contact / effective radius: 0.1 R for equal cylinders

}    // namespace

void PairLaws::allocate(int types)
{
  types_ = types;
  const std::size_t n = at(types, types) + 1;
  laws_.assign(n, ContactLaw());
  arguments_.assign(n, LawArguments());
}

void PairLaws::make(int i, int j)
{
  const LawArguments &args = arguments_[at(i, j)];
  const Material second = args.second.value_or(args.first);
  laws_[at(i, j)] = args.contact(args.first, second);
  laws_[at(j, i)] = args.contact(second, args.first);
  arguments_[at(j, i)] = args;
}

void PairLaws::begin_run(std::shared_ptr<const Cylinders> cylinders)
{
  cylinders_ = std::move(cylinders);
  has_special_ = false;
  special_.assign(laws_.size(), 0);
  geometries_.clear();
  geometries_.resize(laws_.size());
  special_pairs_.clear();
}

void PairLaws::make_special(int i, int j)
{
  has_special_ = true;
  special_[at(i, j)] = special_[at(j, i)] = 1;
  if (!shaped(i, j)) return;
  geometries_[at(i, j)] = std::make_unique<CylinderPair>(cylinders_->shape(i), cylinders_->shape(j));
  geometries_[at(j, i)] = std::make_unique<CylinderPair>(cylinders_->shape(j), cylinders_->shape(i));
}

ScaledLaw PairLaws::special_law(int i, int j, double ri, double rj)
{
  const ContactLaw &of_types = law(i, j);
  const CylinderPair *const shapes = geometry(i, j);
  if (!shapes) return ScaledLaw(of_types, effective_radius(ri, rj), ri, rj);
  SpecialPair &pair = special_pairs_[{i, j, ri, rj}];
  if (pair.contact.effective_radius() > 0.0) return pair.contact;
  if (ri == 0.0 || rj == 0.0) {
    Error *const error = lmp_->error;
    error->one(FLERR, "Pair style gran/hysteretic: a flat face touches a cylinder; flat faces can touch spheres only");
  }
  const double radius = shapes->effective_radius(ri, rj);
  pair.contact = ScaledLaw(of_types, radius);
  if (shapes->parallel()) {
    const LawArguments &args = arguments_[at(i, j)];
    const Material second = args.second.value_or(args.first);
    const bool swapped = i > j;
    const double length = shapes->length();
    const LineContact line =
        cylinders_->plane_strain
            ? LineContact::plane_strain(args.first, second, swapped ? rj : ri, swapped ? ri : rj, length)
            : LineContact(args.first, second, 2.0 * effective_radius(ri, rj), length);
    pair.line = std::make_unique<ElasticContact>(line, VALID * radius);
    pair.contact = ScaledLaw(of_types, radius, *pair.line);
  }
  return pair.contact;
}

PairParameters PairLaws::parameters(int i, int j, double ri, double rj)
{
  const LawArguments &args = arguments_[at(i, j)];
  PairParameters p;
  p.radius_i = ri;
  p.radius_j = rj;
  p.radsum = ri + rj;
  p.touch_sq = TouchingPairs::touch_squared(p.radsum);
  p.largest_overlap = largest_overlap(ri, rj);
  p.contact = scaled(i, j, ri, rj);
  p.root_radius = std::sqrt(p.contact.effective_radius());
  if (has_special_) p.largest_overlap = std::min(p.largest_overlap, p.contact.largest_overlap());
  p.friction = ri > 0.0 && rj > 0.0 ? args.friction : 0.0;
  p.shear_stiffness = law(i, j).tangential_stiffness(1.0);
  p.tangential_model = args.tangential;
  p.loss = args.loss;
  if (args.resistance && ri > 0.0 && rj > 0.0) p.resistance = &args.resistance;
  return p;
}

void PairLaws::fill_table(const std::vector<double> &radius)
{
  table_.resize(laws_.size());
  for (int i = 1; i <= types_; i++)
    for (int j = 1; j <= types_; j++)
      if (radius[i] >= 0.0 && radius[j] >= 0.0 && radius[i] + radius[j] > 0.0)
        table_[at(i, j)] = parameters(i, j, radius[i], radius[j]);
}

}    // namespace granwave
