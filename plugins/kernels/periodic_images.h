// SPDX-License-Identifier: GPL-2.0-only
/* Vectors between two spheres across a periodic boundary, from the coordinates of one sphere and of a ghost of the other.
   LAMMPS rounds the coordinates of ghosts, x_i - s and x_j + s with the shift s of the image, so that the vectors to them
   differ in their last bits. Both ghosts are known in either case, since a coordinate that is there can be shifted as
   LAMMPS does it: the vector is computed from the two ghosts, as (x_i - s) - (x_j + s) + s. No LAMMPS types. */

#ifndef GRANWAVE_PERIODIC_IMAGES_H
#define GRANWAVE_PERIODIC_IMAGES_H

#include "../laws/kernel.h"

#include <cstdint>

namespace granwave {

/* Shifts of a ghost along x, y and z by its images along the three edges of the box, one after the other, as LAMMPS makes them. */
struct ImageShift {
  double along[3][3];
};

/* The edges are those of LAMMPS: lx, ly, lz, yz, xz, xy. */
GRANWAVE_KERNEL ImageShift image_shift(const std::int8_t (&images)[3], const double (&edges)[6])
{
  const double along_a = images[0], along_b = images[1], along_c = images[2];
  return {{{along_a * edges[0], along_b * edges[5], along_c * edges[4]},
           {0.0, along_b * edges[1], along_c * edges[3]},
           {0.0, 0.0, along_c * edges[2]}}};
}

/* Shifts of all ghosts that are at most one image away along each edge. */
class ShiftTable {
 public:
  void set(const double (&edges)[6])
  {
    for (int n = 0; n < SIZE; n++) {
      const std::int8_t images[3] = {static_cast<std::int8_t>(n % 3 - 1), static_cast<std::int8_t>(n / 3 % 3 - 1),
                                     static_cast<std::int8_t>(n / 9 - 1)};
      shifts_[n] = image_shift(images, edges);
    }
  }

  /* Shift of a ghost, or null if it is further away. */
  const ImageShift *of(const std::int8_t (&images)[3]) const
  {
    for (const std::int8_t along : images)
      if (along < -1 || along > 1) return nullptr;
    return shifts_ + (images[0] + 1) + 3 * (images[1] + 1) + 9 * (images[2] + 1);
  }

 private:
  static constexpr int SIZE = 27;    // -1, 0 or 1 along each of three edges
  ImageShift shifts_[SIZE] = {};
};

/* Difference of a quantity between spheres i and j, one of which is a ghost, from the image shifts of both.

   ghost_is_j  true if the ghost is that of j
   shifted     _i, _j: whether the quantities of i and j are shifted with their ghosts */
GRANWAVE_KERNEL void image_difference(const double *of_i, const double *of_j, const ImageShift &shifts, bool ghost_is_j,
                                      bool shifted_i, bool shifted_j, double *result)
{
  const bool present_is_shifted = ghost_is_j ? shifted_i : shifted_j;
  for (int d = 0; d < 3; d++) {
    double present = ghost_is_j ? of_i[d] : of_j[d], whole = 0.0;
    for (int n = 0; n < 3; n++) {
      const double shift = shifts.along[d][n];
      if (present_is_shifted) present -= shift;
      whole += shift;
    }
    const double apart = ghost_is_j ? present - of_j[d] : of_i[d] - present;
    const double back = ghost_is_j ? whole : -whole;
    result[d] = shifted_i && shifted_j ? apart + back : apart;
  }
}

}    // namespace granwave

#endif
