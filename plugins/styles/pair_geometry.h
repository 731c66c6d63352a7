// SPDX-License-Identifier: GPL-2.0-only
/* Distance, normal and relative velocity of the two bodies of a pair, across periodic boundaries too.

   A pair across a periodic boundary is computed for each of its spheres i and j, once with j and a ghost of i, and once with i and a ghost
   of j, from the same numbers (periodic_images.h). */

#ifndef GRANWAVE_PAIR_GEOMETRY_H
#define GRANWAVE_PAIR_GEOMETRY_H

#include "../kernels/periodic_images.h"
#include "fix_gran_hysteretic_history.h"
#include "pair_laws.h"

#include "atom.h"

#include <array>

namespace granwave {

class PairGeometry {
 public:
  using Vector = std::array<double, 3>;

  PairGeometry(LAMMPS_NS::LAMMPS *lmp, const PairLaws &laws) : lmp_(lmp), laws_(laws) {}

  /* Begin a run, with the fix that stores the images of ghosts. Normals are those of the places in a custom array, or of
     the present ones if its index is below 0. */
  void begin_run(const LAMMPS_NS::FixGranHystereticHistory *, int initial_places);
  /* Begin a force evaluation: a box that is deformed may change velocities at its periodic boundaries. */
  void begin_evaluation();

  /* Compute the shifts of ghosts, for the functions `shifted_` in the same force evaluation. */
  void set_shifts();

  /* True if velocities jump across periodic boundaries. */
  bool flows() const { return flows_; }
  /* Images of a ghost, none for an owned atom. */
  const LAMMPS_NS::FixGranHystereticHistory::Images &images(int i) const { return history_->images(i); }
  /* True if spheres i and j touch across a periodic boundary. */
  bool crosses(int i, int j) const { return !images(i).none() || !images(j).none(); }
  /* Vector from sphere j to sphere i. */
  Vector vector_between(int i, int j) const;
  /* Velocity of sphere i relative to sphere j. */
  Vector relative_velocity(int i, int j) const;
  /* The same numbers to the last bit, from the shifts that are known. */
  Vector shifted_vector(int i, int j) const;
  Vector shifted_velocity(int i, int j) const;
  /* Separation of the bodies of a special pair. */
  CylinderPair::Separation separation(int i, int j) const;
  double distance_squared(int i, int j) const;
  /* The same from the stored coordinates of both; across a periodic boundary the last bits differ. */
  double rounded_distance_squared(int i, int j) const
  {
    const double *const xi = lmp_->atom->x[i], *const xj = lmp_->atom->x[j];
    const double delx = xi[0] - xj[0], dely = xi[1] - xj[1], delz = xi[2] - xj[2];
    return delx * delx + dely * dely + delz * delz;
  }
  /* Distance from which the overlap is measured, from the squared distance of the centers. Beyond the end of a cylinder
     it is the distance of the centers. */
  double distance(int i, int j, double rsq) const;
  double distance(int i, int j) const { return distance(i, j, distance_squared(i, j)); }
  /* Unit vector along which the surface of sphere j presses sphere i. */
  void unit_normal(int i, int j, double (&normal)[3]) const;

 private:
  LAMMPS_NS::LAMMPS *lmp_;
  const PairLaws &laws_;
  const LAMMPS_NS::FixGranHystereticHistory *history_ = nullptr;
  int initial_places_ = -1;    // index of the custom array that holds the places at which normals are taken
  bool flows_ = false;
  ShiftTable shifts_, velocity_shifts_;

  const LAMMPS_NS::FixGranHystereticHistory::Images &images_between(int i, int j) const;
  Vector velocity_across(int i, int j, const ImageShift &) const;
};

}    // namespace granwave

#endif
