// SPDX-License-Identifier: GPL-2.0-only
#include "pair_geometry.h"

#include "../kernels/periodic_images.h"

#include "atom.h"
#include "domain.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

namespace granwave {

namespace {

using Vector = PairGeometry::Vector;

Vector plain_difference(const double *of_i, const double *of_j)
{
  return {of_i[0] - of_j[0], of_i[1] - of_j[1], of_i[2] - of_j[2]};
}

}    // namespace

void PairGeometry::begin_run(const FixGranHystereticHistory *history, int initial_places)
{
  history_ = history;
  initial_places_ = initial_places;
}

void PairGeometry::begin_evaluation() { flows_ = lmp_->domain->deform_vremap != 0; }

PairGeometry::Vector PairGeometry::vector_between(int i, int j) const
{
  const Atom &atom = *lmp_->atom;
  const Domain &domain = *lmp_->domain;
  const double *const xi = atom.x[i], *const xj = atom.x[j];
  const bool ghost_is_j = images(i).none();
  const auto &of_ghost = images(ghost_is_j ? j : i);
  if (of_ghost.none()) return plain_difference(xi, xj);
  const double edges[6] = {domain.xprd, domain.yprd, domain.zprd, domain.yz, domain.xz, domain.xy};
  Vector between;
  image_difference(xi, xj, image_shift(of_ghost.along, edges), ghost_is_j, true, true, between.data());
  return between;
}

PairGeometry::Vector PairGeometry::relative_velocity(int i, int j) const
{
  const Atom &atom = *lmp_->atom;
  const Domain &domain = *lmp_->domain;
  const double *const vi = atom.v[i], *const vj = atom.v[j];
  const bool ghost_is_j = images(i).none();
  const auto &of_ghost = images(ghost_is_j ? j : i);
  if (!flows_ || of_ghost.none()) return plain_difference(vi, vj);
  const int group = domain.deform_groupbit;
  const bool jumps_i = (atom.mask[i] & group) != 0, jumps_j = (atom.mask[j] & group) != 0;
  Vector relative;
  image_difference(vi, vj, image_shift(of_ghost.along, domain.h_rate), ghost_is_j, jumps_i, jumps_j, relative.data());
  return relative;
}

CylinderPair::Separation PairGeometry::separation(int i, int j) const
{
  const Atom &atom = *lmp_->atom;
  const Vector del = vector_between(i, j);
  if (const CylinderPair *const shapes = laws_.geometry(atom.type[i], atom.type[j])) return shapes->separation(del.data());
  if (initial_places_ >= 0) {
    const double *const *const start = atom.darray[initial_places_];
    double normal[3];
    for (int d = 0; d < 3; d++) normal[d] = start[i][d] - start[j][d];
    const double apart = std::sqrt(dot(normal, normal));
    for (double &component : normal) component /= apart;
    const double along = del[0] * normal[0] + del[1] * normal[1] + del[2] * normal[2];
    return {along, {normal[0], normal[1], normal[2]}, -1.0};
  }
  const double r = std::sqrt(del[0] * del[0] + del[1] * del[1] + del[2] * del[2]);
  return {r, {del[0] / r, del[1] / r, del[2] / r}, -1.0};
}

double PairGeometry::distance_squared(int i, int j) const
{
  const Vector del = vector_between(i, j);
  return del[0] * del[0] + del[1] * del[1] + del[2] * del[2];
}

double PairGeometry::distance(int i, int j, double rsq) const
{
  const Atom &atom = *lmp_->atom;
  if (!laws_.is_special(atom.type[i], atom.type[j])) return std::sqrt(rsq);
  const CylinderPair::Separation found = separation(i, j);
  return found.beyond > 0.0 ? std::max(std::sqrt(rsq), atom.radius[i] + atom.radius[j]) : found.distance;
}

void PairGeometry::unit_normal(int i, int j, double (&normal)[3]) const
{
  const Atom &atom = *lmp_->atom;
  if (laws_.is_special(atom.type[i], atom.type[j])) {
    std::copy_n(separation(i, j).normal, 3, normal);
    return;
  }
  const Vector del = vector_between(i, j);
  const double apart = std::sqrt(distance_squared(i, j));
  for (int d = 0; d < 3; d++) normal[d] = del[d] / apart;
}

}    // namespace granwave
