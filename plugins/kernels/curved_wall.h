// SPDX-License-Identifier: GPL-2.0-only
/* Wall other than a plane across an axis: a tube, a face of a region, or a patch of triangles. A sphere has at most one
   contact with it. */

#ifndef GRANWAVE_CURVED_WALL_H
#define GRANWAVE_CURVED_WALL_H

namespace granwave {

class CurvedWall {
 public:
  virtual ~CurvedWall() = default;

  /* True if a sphere of this radius fits between the parts of the wall. */
  virtual bool holds(double radius) const = 0;
  /* Overlap of a sphere with the wall; negative for a gap. */
  virtual double overlap(const double *x, double radius) = 0;
  /* Unit normal at a sphere, away from the wall. */
  virtual void inward(const double *x, double normal[3]) = 0;
  /* Location of a sphere along the wall. */
  virtual void place(const double *x, double found[3]) = 0;
  /* Resolve a force at a sphere into its outward component, and components along the wall, as far as these are defined. */
  virtual void components(const double *x, double force[3]) = 0;
  /* Radius of the sphere that is as stiff on a plane as a sphere of this radius at the wall. */
  virtual double effective_radius(double radius) = 0;
  /* Period of the first coordinate of a location; 0 if it has none. */
  virtual double circumference() const { return 0.0; }
  /* True if it has a fixed position in space, and locations of three coordinates; false for a tube. */
  virtual bool is_in_space() const { return false; }
  /* Noun for messages. */
  virtual const char *kind() const { return "tube"; }
  /* Begin a run, with the skin of the neighbor lists: larger gaps need not be found. Raises std::invalid_argument. */
  virtual void init(double) {}
  /* Name of the wall in messages, with its size. */
  virtual const char *name() const = 0;
};

}    // namespace granwave

#endif
