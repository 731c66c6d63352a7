/* Words of an input script -> contact law; the one syntax that the pair style and the wall fix share:

     hertz E nu [E2 nu2]
     elastoplastic | bilinear | thornton  E nu sigma_y [E2 nu2 sigma_y2]      (INF for one sigma_y: that body never yields)
     keywords: friction mu, tangential mindlin_rescale|mindlin, variant continuous|published, yield_factor C, any of LAW_CONSTANTS (elastoplastic),
     beta b (bilinear)  */

#ifndef GRANWAVE_LAW_ARGUMENTS_H
#define GRANWAVE_LAW_ARGUMENTS_H

#include "contact_laws.h"
#include "tangential.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace granwave {

struct LawArguments {
  Law law = Law::hertz;
  Material first{0, 0, INFINITE};
  std::optional<Material> second;
  Variant variant = Variant::continuous;
  double yield_factor = 1.6, beta = 0.8;
  double friction = 0.0;    // Coulomb's coefficient
  Grip grip = Grip::RESCALED;
  LawConstants constants;

  bool same_options(const LawArguments &other) const
  {
    return law == other.law && variant == other.variant && yield_factor == other.yield_factor && beta == other.beta &&
        friction == other.friction && grip == other.grip && constants == other.constants;
  }

  ContactLaw contact(const Material &m1, const Material &m2) const
  {
    return ContactLaw(law, m1, m2, variant, yield_factor, beta, constants);
  }
};

/* Raises std::invalid_argument with what was found and what was expected. */
LawArguments parse_law(const std::vector<std::string> &words);

const char *law_name(Law law);

/* The member that a name of LAW_CONSTANTS stands for; null if it is none. */
double LawConstants::*law_constant(const std::string &name);

}    // namespace granwave

#endif
