// SPDX-License-Identifier: GPL-2.0-only
/* Command gran/dents: dents of pair style gran/hysteretic and its walls from before a run.

   gran/dents read FILE     dents by ids: lines `i j peak` of two spheres, `FIXID i peak` of a sphere and a wall, # comments
   gran/dents begin         all dents so far are initial ones  */

#ifndef LMP_GRAN_DENTS_H
#define LMP_GRAN_DENTS_H

#include "command.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class FixWallGranHysteretic;
class PairGranHysteretic;

class GranDents : public Command {
 public:
  static constexpr const char *STYLE = "gran/dents";

  explicit GranDents(LAMMPS *lmp) : Command(lmp) {}
  void command(int, char **) override;

 private:
  struct Line {
    int number;
    FixWallGranHysteretic *wall;    // null: a pair of spheres
    tagint i, j;                    // lower id first; j alone of a wall
    double peak;
  };

  void build_lists();
  std::vector<Line> read(const std::string &file);
  void set(const std::string &file, const std::vector<Line> &);

  PairGranHysteretic *pair = nullptr;
};

}    // namespace LAMMPS_NS

#endif
