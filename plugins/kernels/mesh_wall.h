// SPDX-License-Identifier: GPL-2.0-only
/* Smooth patch of a surface of triangles as a wall. It counts as flat: a sphere at the patch is as stiff as on a plane. */

#ifndef GRANWAVE_MESH_WALL_H
#define GRANWAVE_MESH_WALL_H

#include "curved_wall.h"
#include "triangle_mesh.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace granwave {

class MeshWall : public CurvedWall {
 public:
  /* The patches of an STL file, of this path and content, are numbered from 1. Raises std::invalid_argument. */
  MeshWall(const std::string &path, const std::string &content, double angle, int patch) :
      mesh_(read_stl(content), angle), patch_(patch - 1)
  {
    const std::string n = std::to_string(mesh_.n_patches());
    if (patch_ < 0 || patch_ >= mesh_.n_patches())
      throw std::invalid_argument(path + " has patches 1 to " + n + ", found " + std::to_string(patch));
    name_ = "patch " + std::to_string(patch) + " of " + path;
  }

  bool holds(double) const override { return true; }
  bool is_in_space() const override { return true; }
  const char *kind() const override { return "mesh"; }
  void init(double skin) override { skin_ = skin; }
  double overlap(const double *x, double radius) override
  {
    look(x, radius + skin_);
    if (!nearest_.found()) return -std::numeric_limits<double>::infinity();
    // at the center of the sphere: the side is undefined
    if (nearest_.distance == 0.0) return std::numeric_limits<double>::infinity();
    const double overlap = radius - nearest_.distance;
    return overlap > 0.0 && !mesh_.owns(x, patch_, nearest_) ? 0.0 : overlap;
  }
  void inward(const double *x, double normal[3]) override
  {
    look(x);
    std::copy_n(nearest_.normal, 3, normal);
  }
  void place(const double *x, double found[3]) override
  {
    look(x);
    std::copy_n(nearest_.point, 3, found);
  }
  void components(const double *, double force[3]) override
  {
    force[0] = -(force[0] * nearest_.normal[0] + force[1] * nearest_.normal[1] + force[2] * nearest_.normal[2]);
    force[1] = force[2] = 0.0;
  }
  double effective_radius(double radius) override { return radius; }
  const char *name() const override { return name_.c_str(); }

 private:
  /* Find the point of the patch that is nearest to x, closer than `reach`. */
  void look(const double *x, double reach = std::numeric_limits<double>::infinity())
  {
    const bool is_same = std::equal(x, x + 3, at_);
    if (is_same && (nearest_.found() || reach <= reach_)) return;
    std::copy_n(x, 3, at_);
    reach_ = reach;
    nearest_ = mesh_.nearest(x, patch_, reach);
  }

  TriangleMesh mesh_;
  int patch_;
  std::string name_;
  double skin_ = std::numeric_limits<double>::infinity();
  double at_[3] = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};    // the last position
  double reach_ = 0.0;
  SurfacePoint nearest_;
};

}    // namespace granwave

#endif
