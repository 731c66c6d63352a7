// SPDX-License-Identifier: GPL-2.0-only
#include "region_wall.h"

#include "../laws/cylinders.h"
#include "domain.h"
#include "region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

using namespace LAMMPS_NS;

namespace {

constexpr double ANYWHERE = 1e20;    // distance within which a region searches for its surface
constexpr double ASIDE = 0.05;       // offset from the middle of a region / its width
constexpr double OUTSIDE = 1e6;      // distance of a point far outside / size of the box
constexpr const char *WHOLE = "all";

/* Faces of the inside of a region, in the order of their numbers in LAMMPS. */
const std::map<std::string, std::vector<std::string>> FACES = {
    {"plane", {WHOLE}},
    {"sphere", {WHOLE}},
    {"block", {"xlo", "xhi", "ylo", "yhi", "zlo", "zhi"}},
    {"cylinder", {"lo", "hi", "side"}},
    {"cone", {"lo", "hi", "side"}},
};

std::string joined(const std::vector<std::string> &words)
{
  std::string text;
  for (const auto &word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}    // namespace

namespace granwave {

RegionWall::RegionWall(LAMMPS *lmp, const std::string &id, const std::string &face) : lmp_(lmp), id_(id), face_(face)
{
  find();
}

void RegionWall::find()
{
  region_ = lmp_->domain->get_region_by_id(id_);
  if (!region_) throw std::invalid_argument("there is no region " + id_);
  const std::string style = region_->style;
  const auto faces = FACES.find(style);
  if (faces == FACES.end())
    throw std::invalid_argument("a region is of style plane, sphere, block, cylinder or cone, found " + style +
                                ": use a fix for each of its parts");
  if (region_->dynamic_check())
    throw std::invalid_argument("region " + id_ + " moves or changes its shape, expected one at rest");
  const std::vector<std::string> names = region_->interior ? faces->second : std::vector<std::string>{WHOLE};
  const auto place = std::find(names.begin(), names.end(), face_);
  const std::string kind = region_->interior ? style : "outside of a " + style;
  if (place == names.end())
    throw std::invalid_argument("a face of the " + kind + " is one of " + joined(names) + ", found " + face_);
  if (!region_->interior && region_->openflag)
    throw std::invalid_argument("the outside of region " + id_ + " has open faces, expected closed ones");
  number_ = static_cast<int>(place - names.begin());
  if (region_->interior && region_->openflag && region_->open_faces[number_])
    throw std::invalid_argument("face " + face_ + " of region " + id_ + " is open");
  name_ = "face " + face_ + " of region " + id_;
  looked_ = false;
}

void RegionWall::init(double)
{
  find();
  measure_curvature();
}

/* Ask the region for its curvature at a point inside it, or far outside: for a cylinder this is half of its smaller
   radius. */
void RegionWall::measure_curvature()
{
  curvature_ = 0.0;
  effective_.clear();
  const std::string style = region_->style;
  const bool is_sphere = style == "sphere", is_side = style == "cylinder" && (face_ == "side" || !region_->interior);
  if (!is_sphere && !is_side) return;
  double point[3];
  const Domain *const domain = lmp_->domain;
  const double low[3] = {region_->extent_xlo, region_->extent_ylo, region_->extent_zlo},
               high[3] = {region_->extent_xhi, region_->extent_yhi, region_->extent_zhi};
  double width = high[0] - low[0];
  for (int d = 1; d < 3; d++) width = std::min(width, high[d] - low[d]);
  for (int d = 0; d < 3; d++) {
    const double far = domain->boxhi[d] + OUTSIDE * (domain->prd[0] + domain->prd[1] + domain->prd[2]);
    point[d] = region_->interior ? 0.5 * (low[d] + high[d]) + ASIDE * width : far;
  }
  look(point);
  // far from all axes the normal of an infinite cylinder is perpendicular to its own; for a finite cylinder the rim is
  // nearest
  const double *const normal = nearest_.normal;
  const bool is_rim = !is_sphere && !region_->interior && normal[0] * normal[1] * normal[2] != 0.0;
  if (!nearest_.found || nearest_.radius == 0.0 || is_rim)
    throw std::invalid_argument("the outside of cylinder " + id_ +
                                " has ends, whose curvature differs from that of its side: give it the bounds INF INF");
  curvature_ = (is_sphere ? 1.0 : 2.0) / nearest_.radius;
}

/* Find the point of the face that is nearest to x. */
void RegionWall::look(const double *x)
{
  if (looked_ && std::equal(x, x + 3, nearest_.at)) return;
  looked_ = true;
  std::copy_n(x, 3, nearest_.at);
  nearest_.found = false;
  const bool beyond = region_->interior && region_->openflag && !region_->inside(x[0], x[1], x[2]);
  if (beyond && face_ != "side") return;
  const int n = region_->surface(x[0], x[1], x[2], ANYWHERE);
  for (int k = 0; k < n; k++) {
    const Region::Contact &contact = region_->contact[k];
    if (!beyond && contact.iwall != number_) continue;
    if (!(contact.r > 0.0)) continue;
    nearest_.found = true;
    nearest_.distance = contact.r;
    nearest_.radius = contact.radius;
    const double step[3] = {contact.delx, contact.dely, contact.delz};
    for (int d = 0; d < 3; d++) nearest_.normal[d] = step[d] / contact.r;
    return;
  }
}

double RegionWall::overlap(const double *x, double radius)
{
  look(x);
  return nearest_.found ? radius - nearest_.distance : -INFINITE;
}

void RegionWall::inward(const double *x, double normal[3])
{
  look(x);
  for (int d = 0; d < 3; d++) normal[d] = nearest_.found ? nearest_.normal[d] : 0.0;
}

void RegionWall::place(const double *x, double found[3])
{
  look(x);
  for (int d = 0; d < 3; d++) found[d] = x[d] - (nearest_.found ? nearest_.distance * nearest_.normal[d] : 0.0);
}

void RegionWall::components(const double *x, double force[3])
{
  double normal[3];
  inward(x, normal);
  force[0] = -(force[0] * normal[0] + force[1] * normal[1] + force[2] * normal[2]);
  force[1] = force[2] = 0.0;
}

double RegionWall::effective_radius(double radius)
{
  if (curvature_ == 0.0 || !(radius > 0.0) || !holds(radius)) return radius;
  const auto [known, fresh] = effective_.try_emplace(radius, 0.0);
  if (fresh) {
    const double across = 1.0 / radius + curvature_;
    const bool is_sphere = std::string(region_->style) == "sphere";
    known->second = is_sphere ? 1.0 / across : elliptic_radius(1.0 / radius, across);
  }
  return known->second;
}

}    // namespace granwave
