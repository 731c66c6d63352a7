// SPDX-License-Identifier: GPL-2.0-only
/* Table of contact laws, with their names and options in input scripts, restart files and Python. A new law requires a
   header in this folder, its class in AnyLaw, and an entry in law_arguments.cpp. No LAMMPS types. */

#ifndef GRANWAVE_LAW_TABLE_H
#define GRANWAVE_LAW_TABLE_H

#include "cohesion.h"
#include "elastoplastic.h"
#include "rate_dependent.h"

#include <variant>
#include <vector>

namespace granwave {

/* Options of all laws; each law uses those listed in its table entry. */
struct LawOptions {
  Variant variant = Variant::continuous;
  double yield_factor = 1.6, beta = 0.8;
  double constant = 0.0, exponent = 1.5;    // F = constant overlap^exponent
  LawConstants constants;
  FeConstants fe_constants;    // of elastoplastic-fe, set only where it is fitted
  CohesionModel cohesion;

  bool operator==(const LawOptions &other) const
  {
    return variant == other.variant && yield_factor == other.yield_factor && beta == other.beta &&
           constant == other.constant && exponent == other.exponent && constants == other.constants &&
           cohesion == other.cohesion;
  }
};

using AnyLaw = std::variant<Hertz, Elastoplastic, Bilinear, Thornton, ElastoplasticFe, RateDependent<Elastoplastic>,
                            RateDependent<Thornton>, RateDependent<ElastoplasticFe>>;

/* Scales of a pair of materials, on which a law may depend. */
struct LawScales {
  double yield_strength;        // of the softer body
  double overlap_per_radius;    // alpha_y / R*
  double force_per_area;        // F_y / R*^2
  Material first, second;
};

enum LawOption : unsigned { VARIANT = 1, YIELD_FACTOR = 2, BETA = 4, CONSTANTS = 8, POWER = 16, HARDENING = 32, RATE = 64 };

struct LawEntry {
  const char *name;
  double elastic_limit;    // overlap up to which a contact is Hertzian, without dent, in alpha_y; infinite without yield
  bool fitted;             // true for a fit, valid up to overlaps of 0.2 R*
  unsigned options;        // LawOption
  int n_extra;             // doubles of history beyond the largest overlap
  AnyLaw (*make)(const LawOptions &, const LawScales &);    // Hertz's for a power of the overlap, which has no history
  bool no_force = false;
  bool exact_yield = false;     // first yield where von Mises' stress reaches the yield strength, for every Poisson's ratio
  bool states_error = false;    // true if it has error bars of its own

  bool yields() const { return elastic_limit < INFINITE; }    // requires the yield strength of at least one body
  bool takes(LawOption option) const { return options & option; }
  bool is_power() const { return options & POWER || no_force; }    // of the overlap, whatever the radii
};

/* All laws, in the order of their numbers in restart files. */
const std::vector<LawEntry> &law_table();

/* Find a law by name; null if there is none. */
const LawEntry *find_law(const std::string &name);

/* Names of all laws, or of those that yield, joined by `separator`. */
std::string law_names(const std::string &separator, bool yielding = false);

}    // namespace granwave

#endif
