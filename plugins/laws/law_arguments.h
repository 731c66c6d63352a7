// SPDX-License-Identifier: GPL-2.0-only
/* Contact law from the words of an input script, the same for pair style and wall fix: LAW E nu [sigma_y] [E2 nu2 [sigma_y2]],
   then keywords with their values; parse_law() has all of them in its message. INF for one sigma_y: that body stays elastic. */

#ifndef GRANWAVE_LAW_ARGUMENTS_H
#define GRANWAVE_LAW_ARGUMENTS_H

#include "contact_law.h"
#include "resistance.h"
#include "viscous_loss.h"

#include <stdexcept>

namespace granwave {

struct LawArguments {
  const LawEntry *law = &law_table().front();
  Material first{0, 0, INFINITE};
  std::optional<Material> second;
  LawOptions options;
  double friction = 0.0;    // Coulomb's coefficient
  TangentialModel tangential = TangentialModel::MINDLIN_RESCALE;
  ResistanceModel resistance;
  ViscousLoss loss;
  std::vector<std::string> words;    // words from which these arguments were read

  bool slips_partially() const { return friction > 0.0 && tangential == TangentialModel::PARTIAL_SLIP; }
  bool same_options(const LawArguments &other) const
  {
    return law == other.law && options == other.options && friction == other.friction && tangential == other.tangential &&
           resistance == other.resistance && loss == other.loss;
  }

  bool has_rate() const { return first[RATE_SENSITIVITY] > 0.0 || (second && (*second)[RATE_SENSITIVITY] > 0.0); }
  // largest number for a pair of these materials
  int n_extra() const { return law->n_extra + (has_rate() ? RATE_EXTRA : 0); }

  ContactLaw contact(const Material &m1, const Material &m2) const { return ContactLaw(*law, m1, m2, options); }
};

/* Model with this name. Throws std::invalid_argument if there is none. */
TangentialModel tangential_model(const std::string &name);

/* Parse the words of a law. Throws std::invalid_argument with the word found and the word expected. */
LawArguments parse_law(const std::vector<std::string> &words);

}    // namespace granwave

#endif
