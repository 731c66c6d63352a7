/* Fix wall/gran/hysteretic: plane walls normal to an axis, with the contact laws and the lasting dents of pair style
   gran/hysteretic.

   fix ID group wall/gran/hysteretic xplane|yplane|zplane LO HI law ...      (law_arguments.h; LO, HI a coordinate or NULL)

   One material: a rigid wall. Two: sphere and wall. A dent belongs to its place on the wall: a sphere that has lifted
   off and lands further away than the radius of the contact circle at the dent starts anew. */

#ifndef LMP_FIX_WALL_GRAN_HYSTERETIC_H
#define LMP_FIX_WALL_GRAN_HYSTERETIC_H

#include "contact_laws.h"
#include "fix.h"

namespace LAMMPS_NS {

class FixWallGranHysteretic : public Fix {
 public:
  static constexpr const char *STYLE = "wall/gran/hysteretic";

  FixWallGranHysteretic(LAMMPS *, int, char **);
  ~FixWallGranHysteretic() override;

  int setmask() override;
  void init() override;
  void setup(int) override;
  void min_setup(int) override;
  void post_force(int) override;
  void min_post_force(int) override;
  double compute_scalar() override;
  double compute_vector(int) override;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  double memory_usage() override;

 private:
  double touch(int i, int side, double overlap, double now);
  double apart(int along, double distance) const;
  void tally();

  int axis = 2;
  double plane[2];    // low and high side, infinite when absent
  granwave::ContactLaw law;
  double **sides = nullptr;    // state of each sphere's dents with the low and the high wall
  double wall_force[3];    // of this processor's spheres on the wall
  bigint tallied = -1;
  double totals[4];    // stored, dissipated, yielded, beyond 0.2 R*; all processors
};

}    // namespace LAMMPS_NS

#endif
