// SPDX-License-Identifier: GPL-2.0-only
/* Face of a region of LAMMPS as a wall: the side of a cylinder or cone, an end of it, a face of a block, a plane, a sphere. The
   distance, the normal and the curvature are those that the region finds. A face has one curvature: that of a cone counts as
   none. Beyond an open end of a region the rim belongs to its side. */

#ifndef LMP_GRANWAVE_REGION_WALL_H
#define LMP_GRANWAVE_REGION_WALL_H

#include "../kernels/curved_wall.h"

#include <string>
#include <unordered_map>

namespace LAMMPS_NS {
class LAMMPS;
class Region;
}    // namespace LAMMPS_NS

namespace granwave {

class RegionWall : public CurvedWall {
 public:
  /* Raises std::invalid_argument if there is no such region or face. */
  RegionWall(LAMMPS_NS::LAMMPS *, const std::string &id, const std::string &face);

  /* Find the region, which may have been redefined, and its curvature. */
  void init(double skin) override;

  bool is_in_space() const override { return true; }
  const char *kind() const override { return "region"; }
  bool holds(double radius) const override { return !(curvature_ < 0.0 && radius * -curvature_ >= 1.0); }
  double overlap(const double *x, double radius) override;
  void inward(const double *x, double normal[3]) override;
  void place(const double *x, double found[3]) override;
  void components(const double *x, double force[3]) override;
  double effective_radius(double radius) override;
  const char *name() const override { return name_.c_str(); }

 private:
  void find();
  void measure_curvature();
  void look(const double *x);

  LAMMPS_NS::LAMMPS *lmp_;
  std::string id_, face_, name_;
  LAMMPS_NS::Region *region_ = nullptr;
  int number_ = 0;            // number of the face in the region
  double curvature_ = 0.0;    // negative where the wall is around the spheres

  struct Nearest {    // point of the face that is nearest to the last position
    double at[3], distance, radius, normal[3];
    bool found;
  };
  Nearest nearest_{};
  bool looked_ = false;
  std::unordered_map<double, double> effective_;    // cached by radius of the spheres
};

}    // namespace granwave

#endif
