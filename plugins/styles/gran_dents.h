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

#include "../kernels/contact_memory.h"
#include "command.h"
#include "motion.h"

#include <map>
#include <string>
#include <utility>
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
  using Ids = std::pair<tagint, tagint>;    // IDs of two spheres, the lower first
  using Owned = std::map<tagint, int>;      // local index of the spheres of this processor, by ID
  struct Line {
    bigint number;
    FixWallGranHysteretic *wall;    // null for a pair of spheres
    tagint i, j;                    // lower ID first; for a wall only j is used
    granwave::KnownContact contact;
  };

  void build_lists();
  void begin(bool keeps);
  void read(const std::string &file);
  Line line_of(const std::string &file, const granwave::TextRow &);
  void require_spheres(const std::string &file, const std::vector<Line> &, const Owned &);
  void set(const std::string &file, std::vector<Line> &, const Owned &);
  void stop_at_first(const std::string &file, bigint first, std::string fault);
  std::string fault_of(const Line &, const std::map<Ids, int> &status, const Owned &);

  PairGranHysteretic *pair = nullptr;
};

}    // namespace LAMMPS_NS

#endif

#endif
