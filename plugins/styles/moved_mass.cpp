// SPDX-License-Identifier: GPL-2.0-only
#include "moved_mass.h"

#include "atom.h"
#include "modify.h"

#include <algorithm>
#include <cstring>
#include <string>

using namespace LAMMPS_NS;

namespace {

constexpr double LEAST = 1e-12;    // tolerance of an inverse mass relative to free bodies, for rounding of the normal

bool is_holder(const std::string &style) { return style == "setforce" || style == "lineforce" || style == "planeforce"; }

/* True for a fix that moves its spheres independently of the forces on them. */
bool prescribes(const std::string &style)
{
  return utils::strmatch(style, "^move") || utils::strmatch(style, "^nve/noforce") || style == "gran/load";
}

}    // namespace

namespace granwave {

int integrated_groups(const LAMMPS *lmp)
{
  int bits = 0;
  for (const auto *fix : lmp->modify->get_fix_list())
    if (fix->time_integrate && !prescribes(fix->style)) bits |= fix->groupbit;
  return bits;
}

void MovedMass::find(LAMMPS *lammps, const Fix *after)
{
  lmp = lammps;
  frozen = 0;
  integrated = integrated_groups(lmp);
  rigid.clear();
  holders.clear();
  bool follows = after == nullptr;
  for (auto *fix : lmp->modify->get_fix_list()) {
    follows = follows || fix == after;
    if (utils::strmatch(fix->style, "^freeze")) frozen |= fix->groupbit;
    if (fix->rigid_flag) rigid.push_back(fix);
    if (follows && is_holder(fix->style)) holders.push_back(fix);
  }
  constexpr int ALL = 1;    // bit of the group `all`
  differs = frozen != 0 || !(integrated & ALL) || !rigid.empty() || !holders.empty();
  spheres.clear();
}

void MovedMass::update()
{
  if (!differs) return;
  const Atom *const atom = lmp->atom;
  spheres.resize(atom->nmax);
  std::fill_n(spheres.begin(), atom->nlocal, Sphere{0.0, {1.0, 1.0, 1.0, 0.0, 0.0, 0.0}});
  for (auto *fix : rigid) {
    int dim;
    const auto *const body = static_cast<const int *>(fix->extract("body", dim));
    const auto *const total = static_cast<const double *>(fix->extract("masstotal", dim));
    if (!body || !total) continue;
    for (int i = 0; i < atom->nlocal; i++)
      if (body[i] >= 0) spheres[i].body = total[body[i]];
  }
  if (!holders.empty()) ask_holders();
  for (int i = 0; i < atom->nlocal; i++)
    if ((atom->mask[i] & frozen) || !(atom->mask[i] & integrated)) std::fill_n(spheres[i].left, 6, 0.0);
}

/* Let the fixes change forces of 0 and of 1 along x, y and z: the differences are the columns of P, of which n.P n needs the
   symmetric part. */
void MovedMass::ask_holders()
{
  constexpr int ROW[6] = {0, 1, 2, 0, 0, 1}, COLUMN[6] = {0, 1, 2, 1, 2, 2};
  const Atom *const atom = lmp->atom;
  const int n = atom->nlocal;
  std::vector<double> forces(3 * static_cast<std::size_t>(n)), without(forces.size());
  if (n > 0) std::copy_n(atom->f[0], forces.size(), forces.begin());
  const auto answer = [&](int axis) {
    for (int i = 0; i < n; i++)
      for (int d = 0; d < 3; d++) atom->f[i][d] = d == axis ? 1.0 : 0.0;
    for (auto *fix : holders) fix->post_force(0);
  };
  answer(-1);
  if (n > 0) std::copy_n(atom->f[0], without.size(), without.begin());
  for (auto &sphere : spheres) std::fill_n(sphere.left, 6, 0.0);
  for (int axis = 0; axis < 3; axis++) {
    answer(axis);
    for (int i = 0; i < n; i++)
      for (int k = 0; k < 6; k++) {
        if (COLUMN[k] == axis) spheres[i].left[k] += 0.5 * (atom->f[i][ROW[k]] - without[3 * i + ROW[k]]);
        if (ROW[k] == axis) spheres[i].left[k] += 0.5 * (atom->f[i][COLUMN[k]] - without[3 * i + COLUMN[k]]);
      }
  }
  if (n > 0) std::copy_n(forces.begin(), forces.size(), atom->f[0]);
}

void MovedMass::pack(int i, double *buffer) const { to_doubles(spheres[i], buffer); }

void MovedMass::unpack(int i, const double *buffer) { spheres[i] = from_doubles<Sphere>(buffer); }

double MovedMass::mass(int i) const { return differs && spheres[i].body > 0.0 ? spheres[i].body : lmp->atom->rmass[i]; }

double MovedMass::effective(int i, int j, const double e[3], double others) const
{
  double moved = others, free = others;
  for (const int sphere : {i, j}) {
    if (sphere == BODY) continue;
    const double inverse = 1.0 / mass(sphere);
    free += inverse;
    if (!differs) {
      moved += inverse;
      continue;
    }
    const double *const p = spheres[sphere].left;
    const double along = p[0] * e[0] * e[0] + p[1] * e[1] * e[1] + p[2] * e[2] * e[2] +
                         2.0 * (p[3] * e[0] * e[1] + p[4] * e[0] * e[2] + p[5] * e[1] * e[2]);
    moved += along * inverse;
  }
  return 1.0 / (moved > LEAST * free ? moved : free);
}

}    // namespace granwave
