// SPDX-License-Identifier: GPL-2.0-only
#include "triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace granwave {
namespace {

constexpr int FEW = 4;       // largest number of triangles in an undivided box
constexpr int DEPTH = 64;    // larger than the number of halvings of any mesh
// tolerance relative to the largest coordinate: twice the precision of a binary STL file
constexpr double SAME_PLACE = 2e-7;
constexpr double SAME_DISTANCE = 4e-15;    // of the same
constexpr double NO_AREA = 1e-14;          // tolerance relative to the square of the longest edge
constexpr double DEGREE = 3.14159265358979323846 / 180.0;

double dot_of(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void subtract(const double *a, const double *b, double *difference)
{
  for (int d = 0; d < 3; d++) difference[d] = a[d] - b[d];
}

void cross_of(const double *a, const double *b, double *product)
{
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}

/* Scale to length 1. Returns false for none. */
bool normalise(double *v)
{
  const double length = std::sqrt(dot_of(v, v));
  if (!(length > 0.0)) return false;
  for (int d = 0; d < 3; d++) v[d] /= length;
  return true;
}

/* a + s (b - a) + t (c - a) */
void combine(const Triangle &triangle, double s, double t, double *point)
{
  const auto &[a, b, c] = triangle.corner;
  for (int d = 0; d < 3; d++) point[d] = a[d] + s * (b[d] - a[d]) + t * (c[d] - a[d]);
}

/* Nearest point of a triangle (C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5). Returns true inside of it. */
bool nearest_of(const Triangle &triangle, const double *x, double *point)
{
  const auto &[a, b, c] = triangle.corner;
  double ab[3], ac[3], ap[3], bp[3], cp[3];
  subtract(b, a, ab);
  subtract(c, a, ac);
  subtract(x, a, ap);
  const double d1 = dot_of(ab, ap), d2 = dot_of(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return combine(triangle, 0.0, 0.0, point), false;
  subtract(x, b, bp);
  const double d3 = dot_of(ab, bp), d4 = dot_of(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return std::copy_n(b, 3, point), false;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return combine(triangle, d1 / (d1 - d3), 0.0, point), false;
  subtract(x, c, cp);
  const double d5 = dot_of(ab, cp), d6 = dot_of(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return std::copy_n(c, 3, point), false;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return combine(triangle, 0.0, d2 / (d2 - d6), point), false;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return combine(triangle, 1.0 - t, t, point), false;
  }
  const double sum = va + vb + vc;
  combine(triangle, vb / sum, vc / sum, point);
  return true;
}

/* Use the nearest point of a triangle if it is nearer. */
void take_nearer(const Triangle &triangle, int number, const double *x, SurfacePoint &nearest)
{
  double point[3], away[3];
  const bool inside = nearest_of(triangle, x, point);
  subtract(x, inside ? triangle.corner[0] : point, away);
  const double height = dot_of(away, triangle.normal);
  const double distance = inside ? std::fabs(height) : std::sqrt(dot_of(away, away));
  if (!(distance < nearest.distance)) return;
  nearest.distance = distance;
  nearest.triangle = number;
  std::copy_n(point, 3, nearest.point);
  for (int d = 0; d < 3; d++)
    nearest.normal[d] = inside           ? std::copysign(triangle.normal[d], triangle.normal[d] * height)
                        : distance > 0.0 ? away[d] / distance
                                         : 0.0;
}

/* Direction from a point of an edge into a triangle, across the edge. */
bool inward_of(const Triangle &triangle, const double *middle, const double *along, double *inward)
{
  for (int d = 0; d < 3; d++)
    inward[d] = (triangle.corner[0][d] + triangle.corner[1][d] + triangle.corner[2][d]) / 3.0 - middle[d];
  const double part = dot_of(inward, along);
  for (int d = 0; d < 3; d++) inward[d] -= part * along[d];
  return normalise(inward);
}

int root_of(std::vector<int> &parent, int number)
{
  while (parent[number] != number) {
    parent[number] = parent[parent[number]];
    number = parent[number];
  }
  return number;
}

double distance_from_box(const double *low, const double *high, const double *x)
{
  double sum = 0.0;
  for (int d = 0; d < 3; d++) {
    const double beyond = std::max({low[d] - x[d], 0.0, x[d] - high[d]});
    sum += beyond * beyond;
  }
  return std::sqrt(sum);
}

void bounds_of(const Triangle &triangle, double *low, double *high)
{
  for (int d = 0; d < 3; d++) {
    const auto [least, most] = std::minmax({triangle.corner[0][d], triangle.corner[1][d], triangle.corner[2][d]});
    low[d] = least;
    high[d] = most;
  }
}

}    // namespace

/* ---------------------------------------------------------------------- tree */

TriangleTree::TriangleTree(const std::vector<Triangle> &triangles, std::vector<int> members) : members_(std::move(members))
{
  boxes_.push_back({{}, {}, 0, static_cast<int>(members_.size()), 0});
  for (std::size_t number = 0; number < boxes_.size(); number++) split(triangles, static_cast<int>(number));
}

void TriangleTree::enclose(const std::vector<Triangle> &triangles, Box &box) const
{
  for (int d = 0; d < 3; d++) {
    box.low[d] = std::numeric_limits<double>::infinity();
    box.high[d] = -std::numeric_limits<double>::infinity();
  }
  for (int n = box.first; n < box.last; n++) {
    double low[3], high[3];
    bounds_of(triangles[members_[n]], low, high);
    for (int d = 0; d < 3; d++) {
      box.low[d] = std::min(box.low[d], low[d]);
      box.high[d] = std::max(box.high[d], high[d]);
    }
  }
}

/* Enclose the members of a box, and divide it along its longest side. */
void TriangleTree::split(const std::vector<Triangle> &triangles, int number)
{
  enclose(triangles, boxes_[number]);
  const Box box = boxes_[number];
  if (box.last - box.first <= FEW) return;
  int longest = 0;
  for (int d = 1; d < 3; d++)
    if (box.high[d] - box.low[d] > box.high[longest] - box.low[longest]) longest = d;
  const auto centre = [&](int member) {
    const Triangle &triangle = triangles[member];
    return triangle.corner[0][longest] + triangle.corner[1][longest] + triangle.corner[2][longest];
  };
  const int middle = (box.first + box.last) / 2;
  std::nth_element(members_.begin() + box.first, members_.begin() + middle, members_.begin() + box.last,
                   [&](int a, int b) { return centre(a) < centre(b) || (centre(a) == centre(b) && a < b); });
  boxes_[number].halves = static_cast<int>(boxes_.size());
  boxes_.push_back({{}, {}, box.first, middle, 0});
  boxes_.push_back({{}, {}, middle, box.last, 0});
}

void TriangleTree::find_nearest(const std::vector<Triangle> &triangles, const double *x, SurfacePoint &nearest) const
{
  struct Open {
    int number;
    double distance;
  };
  Open open[DEPTH];    // boxes are halved repeatedly: one half is left open at each depth
  int n = 0;
  open[n++] = {0, distance_from_box(boxes_[0].low, boxes_[0].high, x)};
  while (n > 0) {
    const Open last = open[--n];
    if (!(last.distance < nearest.distance)) continue;
    const Box &box = boxes_[last.number];
    if (box.halves == 0) {
      for (int k = box.first; k < box.last; k++) take_nearer(triangles[members_[k]], members_[k], x, nearest);
      continue;
    }
    Open halves[2];
    for (int half = 0; half < 2; half++) {
      const Box &part = boxes_[box.halves + half];
      halves[half] = {box.halves + half, distance_from_box(part.low, part.high, x)};
    }
    const int nearer = halves[1].distance < halves[0].distance ? 1 : 0;
    open[n++] = halves[1 - nearer];
    open[n++] = halves[nearer];
  }
}

void TriangleTree::list_near(const double *low, const double *high, double reach, std::vector<int> &list) const
{
  const auto is_near = [&](const Box &box) {
    for (int d = 0; d < 3; d++)
      if (box.low[d] - reach > high[d] || box.high[d] + reach < low[d]) return false;
    return true;
  };
  std::vector<int> open{0};
  while (!open.empty()) {
    const Box &box = boxes_[open.back()];
    open.pop_back();
    if (!is_near(box)) continue;
    if (box.halves) {
      open.push_back(box.halves);
      open.push_back(box.halves + 1);
    } else {
      list.insert(list.end(), members_.begin() + box.first, members_.begin() + box.last);
    }
  }
}

/* ---------------------------------------------------------------------- mesh */

TriangleMesh::TriangleMesh(const std::vector<double> &corners, double angle)
{
  if (!(angle >= 0.0 && angle < 90.0))
    throw std::invalid_argument("the angle of a patch must be from 0 to below 90 degrees");
  add_triangles(corners);
  std::vector<int> numbers(triangles_.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  all_ = TriangleTree(triangles_, numbers);
  std::vector<int> parent = join(angle);
  number_patches(parent);
  find_neighbours();
}

void TriangleMesh::add_triangles(const std::vector<double> &corners)
{
  double largest = 0.0;
  for (std::size_t first = 0; first + 9 <= corners.size(); first += 9) {
    Triangle triangle{};
    for (int n = 0; n < 9; n++) {
      const double number = corners[first + n];
      if (!std::isfinite(number))
        throw std::invalid_argument("triangle " + std::to_string(first / 9 + 1) + " has a corner that is not finite");
      triangle.corner[n / 3][n % 3] = number;
      largest = std::max(largest, std::fabs(number));
    }
    double edges[3][3], longest = 0.0;
    for (int k = 0; k < 3; k++) {
      subtract(triangle.corner[(k + 1) % 3], triangle.corner[k], edges[k]);
      longest = std::max(longest, dot_of(edges[k], edges[k]));
    }
    cross_of(edges[0], edges[1], triangle.normal);
    if (!(std::sqrt(dot_of(triangle.normal, triangle.normal)) > NO_AREA * longest)) continue;
    normalise(triangle.normal);
    triangles_.push_back(triangle);
  }
  if (triangles_.empty()) throw std::invalid_argument("it has no triangle with an area");
  same_place_ = SAME_PLACE * largest;
  same_distance_ = SAME_DISTANCE * largest;
}

/* Join the triangles of each patch. Returns for each triangle a triangle of the same patch, which is itself for the root
   of the patch. */
std::vector<int> TriangleMesh::join(double angle) const
{
  const double straight = std::cos(angle * DEGREE);
  std::vector<int> parent(triangles_.size());
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<int> there;
  for (int number = 0; number < n_triangles(); number++) {
    const Triangle &triangle = triangles_[number];
    for (int k = 0; k < 3; k++) {
      const double *const from = triangle.corner[k], *const to = triangle.corner[(k + 1) % 3];
      double along[3], middle[3], inward[3];
      subtract(to, from, along);
      normalise(along);
      for (int d = 0; d < 3; d++) middle[d] = 0.5 * (from[d] + to[d]);
      if (!inward_of(triangle, middle, along, inward)) continue;
      there.clear();
      all_.list_near(middle, middle, same_place_, there);
      for (const int other : there) {
        const Triangle &next = triangles_[other];
        double point[3], step[3], opposite[3];
        nearest_of(next, middle, point);
        subtract(point, middle, step);
        if (other == number || dot_of(step, step) > same_place_ * same_place_) continue;
        if (!inward_of(next, middle, along, opposite)) continue;
        const bool goes_on = dot_of(inward, opposite) <= -straight;
        if (goes_on && std::fabs(dot_of(triangle.normal, next.normal)) >= straight)
          parent[root_of(parent, number)] = root_of(parent, other);
      }
    }
  }
  return parent;
}

/* Number the patches in the order of their first triangles. */
void TriangleMesh::number_patches(std::vector<int> &parent)
{
  std::vector<int> number_of(triangles_.size(), -1);
  std::vector<std::vector<int>> members;
  for (int number = 0; number < n_triangles(); number++) {
    int &patch = number_of[root_of(parent, number)];
    if (patch < 0) {
      patch = static_cast<int>(members.size());
      members.emplace_back();
    }
    triangles_[number].patch = patch;
    members[patch].push_back(number);
  }
  for (auto &one : members) trees_.emplace_back(triangles_, std::move(one));
}

void TriangleMesh::find_neighbours()
{
  neighbours_.resize(trees_.size());
  std::vector<int> there;
  for (Triangle &triangle : triangles_) {
    double low[3], high[3];
    bounds_of(triangle, low, high);
    there.clear();
    all_.list_near(low, high, same_place_, there);
    for (const int other : there) {
      const int patch = triangles_[other].patch;
      if (patch == triangle.patch) continue;
      triangle.meets_others = true;
      neighbours_[triangle.patch].push_back(patch);
    }
  }
  for (auto &list : neighbours_) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
}

SurfacePoint TriangleMesh::nearest(const double *x, int patch, double reach) const
{
  SurfacePoint nearest;
  nearest.distance = reach;
  trees_[patch].find_nearest(triangles_, x, nearest);
  return nearest;
}

bool TriangleMesh::owns(const double *x, int patch, const SurfacePoint &at) const
{
  if (!triangles_[at.triangle].meets_others) return true;
  std::vector<int> there;
  for (const int other : neighbours_[patch]) {
    there.clear();
    trees_[other].list_near(at.point, at.point, same_place_, there);
    SurfacePoint local;
    for (const int number : there) {
      SurfacePoint touch;
      take_nearer(triangles_[number], number, at.point, touch);
      if (touch.distance <= same_place_) take_nearer(triangles_[number], number, x, local);
    }
    if (!local.found()) continue;
    if (local.distance < at.distance - same_distance_) return false;
    const bool is_same = local.distance <= at.distance + same_distance_;
    if (is_same && other < patch && !(nearest(x, other).distance < local.distance - same_distance_)) return false;
  }
  return true;
}

}    // namespace granwave
