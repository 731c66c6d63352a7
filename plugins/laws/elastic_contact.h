// SPDX-License-Identifier: GPL-2.0-only
/* Elastic contact with a law other than Hertz's: along a line (line_contact.h), or a power of the overlap that does not depend
   on the radii. No LAMMPS types. */

#ifndef GRANWAVE_ELASTIC_CONTACT_H
#define GRANWAVE_ELASTIC_CONTACT_H

#include "line_contact.h"

#include <variant>

namespace granwave {

/* F = constant overlap^exponent; no force at all with constant 0. */
struct PowerContact {
  double constant, exponent;

  double force(double overlap) const { return overlap > LineContact::LEAST ? constant * power(overlap, exponent) : 0.0; }
  double stiffness(double overlap) const
  {
    if (exponent == 1.0) return overlap > LineContact::LEAST ? constant : 0.0;
    return overlap > LineContact::LEAST ? exponent * constant * power(overlap, exponent - 1.0) : 0.0;
  }
  double energy(double overlap) const { return force(overlap) * overlap / (exponent + 1.0); }
};

class ElasticContact {
 public:
  explicit ElasticContact(const PowerContact &law) : law_(law) {}

  /* `valid` is the overlap beyond which a line contact is no longer described. */
  ElasticContact(const LineContact &law, double valid) :
      law_(law), valid_(std::fmin(valid, law.largest_overlap())), largest_(law.largest_overlap())
  {
  }

  double force(double overlap) const
  {
    return std::visit([&](const auto &law) { return law.force(overlap); }, law_);
  }
  double stiffness(double overlap) const
  {
    return std::visit([&](const auto &law) { return law.stiffness(overlap); }, law_);
  }
  double energy(double overlap) const
  {
    return std::visit([&](const auto &law) { return law.energy(overlap); }, law_);
  }
  const LineContact *line() const { return std::get_if<LineContact>(&law_); }
  double valid() const { return valid_; }                // overlap beyond which the law is only an estimate
  double largest_overlap() const { return largest_; }    // where it ends

 private:
  std::variant<LineContact, PowerContact> law_;
  double valid_ = INFINITE, largest_ = INFINITE;
};

}    // namespace granwave

#endif
