// SPDX-License-Identifier: GPL-2.0-only
#include "pair_geometry.h"

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

struct Edges {
  double lengths[6];
};

Edges edges_of(const Domain &domain) { return {{domain.xprd, domain.yprd, domain.zprd, domain.yz, domain.xz, domain.xy}}; }

/* Vector from a sphere at xj to one at xi, of which one is a ghost with this shift. */
Vector vector_across(const double *xi, const double *xj, const ImageShift &shift, bool ghost_is_j)
{
  Vector between;
  image_difference(xi, xj, shift, ghost_is_j, true, true, between.data());
  return between;
}

}    // namespace

void PairGeometry::begin_run(const FixGranHystereticHistory *history, int initial_places)
{
  history_ = history;
  initial_places_ = initial_places;
}

void PairGeometry::begin_evaluation() { flows_ = lmp_->domain->deform_vremap != 0; }

void PairGeometry::set_shifts()
{
  shifts_.set(edges_of(*lmp_->domain).lengths);
  if (flows_) velocity_shifts_.set(lmp_->domain->h_rate);
}

/* Images of the ghost in a pair; none if both spheres are on the same side of all boundaries. */
const FixGranHystereticHistory::Images &PairGeometry::images_between(int i, int j) const
{
  return images(images(i).none() ? j : i);
}

PairGeometry::Vector PairGeometry::vector_between(int i, int j) const
{
  const double *const *const x = lmp_->atom->x;
  const auto &of_ghost = images_between(i, j);
  if (of_ghost.none()) return plain_difference(x[i], x[j]);
  return vector_across(x[i], x[j], image_shift(of_ghost.along, edges_of(*lmp_->domain).lengths), images(i).none());
}

PairGeometry::Vector PairGeometry::shifted_vector(int i, int j) const
{
  const double *const *const x = lmp_->atom->x;
  const auto &of_ghost = images_between(i, j);
  if (of_ghost.none()) return plain_difference(x[i], x[j]);
  const ImageShift *const shift = shifts_.of(of_ghost.along);
  return shift ? vector_across(x[i], x[j], *shift, images(i).none()) : vector_between(i, j);
}

PairGeometry::Vector PairGeometry::velocity_across(int i, int j, const ImageShift &shift) const
{
  const Atom &atom = *lmp_->atom;
  const int group = lmp_->domain->deform_groupbit;
  const bool jumps_i = (atom.mask[i] & group) != 0, jumps_j = (atom.mask[j] & group) != 0;
  Vector relative;
  image_difference(atom.v[i], atom.v[j], shift, images(i).none(), jumps_i, jumps_j, relative.data());
  return relative;
}

PairGeometry::Vector PairGeometry::relative_velocity(int i, int j) const
{
  const double *const *const v = lmp_->atom->v;
  const auto &of_ghost = images_between(i, j);
  if (!flows_ || of_ghost.none()) return plain_difference(v[i], v[j]);
  return velocity_across(i, j, image_shift(of_ghost.along, lmp_->domain->h_rate));
}

PairGeometry::Vector PairGeometry::shifted_velocity(int i, int j) const
{
  const ImageShift *const shift = velocity_shifts_.of(images_between(i, j).along);
  return flows_ && shift ? velocity_across(i, j, *shift) : relative_velocity(i, j);
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
