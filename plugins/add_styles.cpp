/* Registers the styles with LAMMPS, once granwaveplugin.cpp has found that library and styles belong together. */

#include "compute_gran_hysteretic.h"
#include "fix_gran_hysteretic_history.h"
#include "fix_wall_gran_hysteretic.h"
#include "lammps.h"
#include "pair_gran_hysteretic.h"

#include <string>

using namespace LAMMPS_NS;

namespace {

/* The plugin loader's public interface (LAMMPS manual, "Writing plugins"). */
struct Registration {
  const char *version, *style, *name, *info, *author;
  void *creator;
  void *handle;
};
using Register = void (*)(Registration *, void *);

template <class Style> void *create(LAMMPS *lmp) { return static_cast<Pair *>(new Style(lmp)); }
template <class Base, class Style> void *create_named(LAMMPS *lmp, int narg, char **arg)
{
  return static_cast<Base *>(new Style(lmp, narg, arg));
}

}    // namespace

extern "C" __attribute__((visibility("default"))) void granwave_add_styles(void *instance, void *handle, void *regfunc)
{
  auto *lmp = static_cast<LAMMPS *>(instance);
  const auto add = [&](const char *style, const char *name, void *creator) {
    Registration entry{lmp->version, style, name, "contact with dents that last: ", "granwave", creator, handle};
    const std::string info = std::string("granwave ") + GRANWAVE_VERSION + ": " + style + " style " + name;
    entry.info = info.c_str();
    reinterpret_cast<Register>(regfunc)(&entry, lmp);
  };
  add("pair", PairGranHysteretic::STYLE, reinterpret_cast<void *>(&create<PairGranHysteretic>));
  add("fix", FixGranHystereticHistory::STYLE, reinterpret_cast<void *>(&create_named<Fix, FixGranHystereticHistory>));
  add("fix", FixWallGranHysteretic::STYLE, reinterpret_cast<void *>(&create_named<Fix, FixWallGranHysteretic>));
  add("compute", ComputeGranHystereticAtom::STYLE, reinterpret_cast<void *>(&create_named<Compute, ComputeGranHystereticAtom>));
  add("compute", ComputeGranHystereticLocal::STYLE, reinterpret_cast<void *>(&create_named<Compute, ComputeGranHystereticLocal>));
  add("compute", ComputeGranHystereticContact::STYLE, reinterpret_cast<void *>(&create_named<Compute, ComputeGranHystereticContact>));
}
