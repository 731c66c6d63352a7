// SPDX-License-Identifier: GPL-2.0-only
/* Table of contact laws, with their names and parameters in input scripts, restart files and Python. A new law requires a
   header in this folder, with its parameters, its class in AnyLaw, and an entry in law_arguments.cpp. No LAMMPS types. */

#ifndef GRANWAVE_LAW_TABLE_H
#define GRANWAVE_LAW_TABLE_H

#include "cohesion.h"
#include "elastoplastic.h"
#include "rate_dependent.h"

#include <algorithm>
#include <variant>

namespace granwave {

/* F = constant overlap^exponent of law power (elastic_contact.h). */
inline constexpr LawParameter POWER_CONSTANT =
    LawParameter("constant", "K", "law power: constant K of F = K overlap^p, N/m^p").in(POSITIVE).required(2e9);
inline constexpr LawParameter POWER_EXPONENT =
    LawParameter("exponent", "p", "law power: exponent p of F = K overlap^p").in(AT_LEAST_ONE).required(1.5);

/* Inputs of a law in addition to materials. */
struct LawOptions {
  LawValues values;            // values of parameters of the contact
  FeConstants fe_constants;    // constants of elastoplastic-fe, set only if they were fitted
  CohesionModel cohesion;

  bool operator==(const LawOptions &other) const { return values == other.values && cohesion == other.cohesion; }
};

using AnyLaw = std::variant<Hertz, Elastoplastic, Bilinear, Thornton, ElastoplasticFe, RateDependent<Elastoplastic>,
                            RateDependent<Thornton>, RateDependent<ElastoplasticFe>>;

struct LawEntry {
  using Make = AnyLaw (*)(const LawOptions &, const LawScales &);
  using Conflict = std::string (*)(const LawValues &, bool has_constants, bool has_rate);

  const char *name;
  Make make;                                       // Hertz's for a power of the overlap, which has no history
  double elastic_limit = INFINITE;                 // overlap up to which a contact is Hertzian, without dent, in alpha_y
  std::vector<const LawParameter *> parameters;    // in the order of input scripts
  int n_extra = 0;                                 // doubles of history beyond the largest overlap
  bool fitted = false;                             // true for a fit, valid up to overlaps of 0.2 R*
  bool no_force = false;
  // first yield where the von Mises stress reaches the yield strength, for every Poisson's ratio
  bool exact_yield = false;
  bool states_error = false;      // true if it has error bars
  Conflict conflict = nullptr;    // description of incompatible values; empty if there are none

  LawEntry(const char *name, Make make) : name(name), make(make) {}

  LawEntry &yielding_beyond(double overlap) { return set(elastic_limit, overlap); }
  LawEntry &with(std::vector<const LawParameter *> own) { return set(parameters, std::move(own)); }
  LawEntry &with_history(int doubles) { return set(n_extra, doubles); }
  LawEntry &fit() { return set(fitted, true); }
  LawEntry &without_force() { return set(no_force, true); }
  LawEntry &yielding_exactly() { return set(exact_yield, true); }
  LawEntry &with_error_bars() { return set(states_error, true); }
  LawEntry &excluding(Conflict values) { return set(conflict, values); }

  bool yields() const { return elastic_limit < INFINITE; }    // requires the yield strength of at least one body
  bool takes(const LawParameter &parameter) const
  {
    return std::any_of(parameters.begin(), parameters.end(), [&](const LawParameter *own) { return *own == parameter; });
  }
  // power of the overlap, independent of the radii
  bool is_power() const { return takes(POWER_EXPONENT) || no_force; }

  /* Its parameters with this keyword, in order. */
  std::vector<const LawParameter *> with_keyword(const std::string &keyword) const;

  /* True if constants of its curve are set: optional parameters of the contact. */
  bool has_constants(const LawValues &values) const;

  /* Description of incompatible values; empty if there are none. */
  std::string conflict_of(const LawValues &values, bool has_rate) const
  {
    return conflict ? conflict(values, has_constants(values), has_rate) : "";
  }

 private:
  template <class Value> LawEntry &set(Value &member, Value value)
  {
    member = std::move(value);
    return *this;
  }
};

/* All laws, in the order of their numbers in restart files. */
const std::vector<LawEntry> &law_table();

/* Parameters of all laws, without repetition. */
std::vector<const LawParameter *> law_parameters();

/* Find a law by name; null if there is none. */
const LawEntry *find_law(const std::string &name);

/* Names of all laws, or of those that yield, joined by `separator`. */
std::string law_names(const std::string &separator, bool yielding = false);

}    // namespace granwave

#endif
