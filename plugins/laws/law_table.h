// SPDX-License-Identifier: GPL-2.0-only
/* Table of contact laws, which input scripts, restart files and Python take names and options from. A new law is a
   header beside this one, its class in AnyLaw, and an entry in law_table.cpp. No LAMMPS types. */

#ifndef GRANWAVE_LAW_TABLE_H
#define GRANWAVE_LAW_TABLE_H

#include "bilinear.h"
#include "elastoplastic.h"
#include "hertz.h"
#include "thornton.h"

#include <string>
#include <variant>
#include <vector>

namespace granwave {

/* Options of all laws; each law takes those that its entry names. */
struct LawOptions {
  Variant variant = Variant::continuous;
  double yield_factor = 1.6, beta = 0.8;
  LawConstants constants;

  bool operator==(const LawOptions &other) const
  {
    return variant == other.variant && yield_factor == other.yield_factor && beta == other.beta &&
           constants == other.constants;
  }
};

using AnyLaw = std::variant<Hertz, Elastoplastic, Bilinear, Thornton>;

/* Scales of the pair of materials that a law may depend on. */
struct LawScales {
  double yield_strength;        // of the softer body
  double overlap_per_radius;    // alpha_y / R*
  double force_per_area;        // F_y / R*^2
};

enum LawOption : unsigned { VARIANT = 1, YIELD_FACTOR = 2, BETA = 4, CONSTANTS = 8 };

struct LawEntry {
  const char *name;
  double
      elastic_limit;    // overlap up to which a contact is Hertzian and leaves no dent, in alpha_y; infinite: it never yields
  bool fitted;          // a fit, valid to overlaps of 0.2 R*
  unsigned options;     // LawOption
  int n_extra;          // doubles of history beyond the largest overlap
  AnyLaw (*make)(const LawOptions &, const LawScales &);

  bool yields() const { return elastic_limit < INFINITE; }    // and needs the yield strength of one body
  bool takes(LawOption option) const { return options & option; }
};

/* All laws, in the order of their numbers in restart files. */
const std::vector<LawEntry> &law_table();

/* Find a law by name; null if there is none. */
const LawEntry *find_law(const std::string &name);

/* Names of all laws, or of those that yield, joined by `separator`. */
std::string law_names(const std::string &separator, bool yielding = false);

}    // namespace granwave

#endif
