// SPDX-License-Identifier: GPL-2.0-only
/* Command gran/dents: initial dents of pair style gran/hysteretic and of walls.

   gran/dents read FILE     dents by IDs: lines `i j peak` of two spheres, `FIXID i peak` of a sphere and a wall, # comments; with
                            further numbers all that a contact remembers
   gran/dents begin         turn all dents so far into initial dents
   gran/dents clear         forget all dents so far */

#ifdef COMMAND_CLASS
// clang-format off
CommandStyle(gran/dents,GranDents);
// clang-format on
#else

#ifndef LMP_GRAN_DENTS_H
#define LMP_GRAN_DENTS_H

#include "../laws/contact_memory.h"
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
    FixWallGranHysteretic *wall;    // null for a pair of spheres
    tagint i, j;                    // lower ID first; for a wall only j is used
    granwave::KnownContact contact;
  };

  void build_lists();
  void begin(bool keeps);
  std::vector<Line> read(const std::string &file);
  void set(const std::string &file, const std::vector<Line> &);

  PairGranHysteretic *pair = nullptr;
};

}    // namespace LAMMPS_NS

#endif

#endif
