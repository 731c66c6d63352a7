// SPDX-License-Identifier: GPL-2.0-only
/* Surface of triangles as a wall for spheres. No LAMMPS types.

   Triangles that meet at an edge, and turn there by no more than an angle, are one smooth patch. A sphere has one contact with a
   patch, at its nearest point: however many triangles a face has, it counts once, and a sphere that rolls over an edge inside of
   a patch meets no step, as the distance from a set of points is continuous. At an edge or corner that patches share, the contact belongs to one of them:
   to none if another one is nearer there, else to that of the lowest number. In a concave corner a sphere touches each of its faces. Both sides of a triangle are walls. */

#ifndef GRANWAVE_TRIANGLE_MESH_H
#define GRANWAVE_TRIANGLE_MESH_H

#include <limits>
#include <string>
#include <vector>

namespace granwave {

using Place = double[3];

struct Triangle {
  double corner[3][3], normal[3];
  int patch = -1;
  bool meets_others = false;    // another patch is at one of its edges or corners
};

struct SurfacePoint {
  double distance = std::numeric_limits<double>::infinity();
  double point[3] = {}, normal[3] = {};    // the normal points from the surface to the given position
  int triangle = -1;
  bool found() const { return triangle >= 0; }
};

/* Bounding boxes of triangles, halved repeatedly until each contains only a few. */
class TriangleTree {
 public:
  TriangleTree() = default;
  TriangleTree(const std::vector<Triangle> &, std::vector<int> members);

  /* Nearest point of the triangles to x, closer than `reach`. */
  void find_nearest(const std::vector<Triangle> &, const double *x, SurfacePoint &nearest) const;
  /* Triangles whose box is within `reach` of the box from low to high. */
  void list_near(const double *low, const double *high, double reach, std::vector<int> &list) const;

 private:
  struct Box {
    double low[3], high[3];
    int first, last;    // members
    int halves;         // number of the first half; 0: undivided
  };
  void split(const std::vector<Triangle> &, int number);
  void enclose(const std::vector<Triangle> &, Box &) const;
  std::vector<Box> boxes_;
  std::vector<int> members_;
};

class TriangleMesh {
 public:
  /* corners   nine numbers for each triangle; those without an area are left out
     angle     largest turn at an edge inside of a patch, degrees
     Raises std::invalid_argument if no triangle is left, or a number is not finite. */
  TriangleMesh(const std::vector<double> &corners, double angle);

  int n_patches() const { return static_cast<int>(trees_.size()); }
  int n_triangles() const { return static_cast<int>(triangles_.size()); }
  const std::vector<Triangle> &triangles() const { return triangles_; }

  /* Nearest point of a patch to x, closer than `reach`. */
  SurfacePoint nearest(const double *x, int patch, double reach = std::numeric_limits<double>::infinity()) const;
  /* True if a sphere at x touches the surface there at this patch and at no other. */
  bool owns(const double *x, int patch, const SurfacePoint &) const;

 private:
  void add_triangles(const std::vector<double> &corners);
  std::vector<int> join(double angle) const;
  void number_patches(std::vector<int> &parent);
  void find_neighbours();

  std::vector<Triangle> triangles_;
  TriangleTree all_;
  std::vector<TriangleTree> trees_;                  // of each patch
  std::vector<std::vector<int>> neighbours_;         // patches that meet a patch, ascending
  double same_place_ = 0.0, same_distance_ = 0.0;    // tolerances of equal points and equal distances
};

/* Corners of the triangles of an STL file, text or binary: nine numbers each. Raises std::invalid_argument. */
std::vector<double> read_stl(const std::string &content);

/* Content of a file. Raises std::invalid_argument if it cannot be read. */
std::string content_of(const std::string &path);

}    // namespace granwave

#endif
