// SPDX-License-Identifier: GPL-2.0-only
#include "law_table.h"

namespace granwave {

namespace {

AnyLaw make_hertz(const LawOptions &, const LawScales &) { return Hertz(); }

AnyLaw make_elastoplastic(const LawOptions &o, const LawScales &)
{
  return Elastoplastic(o.variant, o.yield_factor, o.constants);
}

AnyLaw make_bilinear(const LawOptions &o, const LawScales &s)
{
  return Bilinear(Bilinear::STIFFNESS * s.yield_strength * s.overlap_per_radius / s.force_per_area, o.beta);
}

AnyLaw make_thornton(const LawOptions &o, const LawScales &) { return Thornton(o.yield_factor); }

}    // namespace

const std::vector<LawEntry> &law_table()
{
  // name, elastic limit, fitted, options, doubles of history beyond the largest overlap; new laws last, since restart files
  // have the number of the line
  static const std::vector<LawEntry> TABLE = {
      {"hertz", INFINITE, false, 0, 0, make_hertz},
      {"elastoplastic", 1.0, true, VARIANT | YIELD_FACTOR | CONSTANTS, 0, make_elastoplastic},
      {"bilinear", 0.0, false, BETA, 0, make_bilinear},
      {"thornton", 1.0, false, YIELD_FACTOR, 0, make_thornton},
      {"power", INFINITE, false, POWER, 0, make_hertz},
      {"none", INFINITE, false, 0, 0, make_hertz, true},
  };
  return TABLE;
}

const LawEntry *find_law(const std::string &name)
{
  for (const LawEntry &entry : law_table())
    if (name == entry.name) return &entry;
  return nullptr;
}

std::string law_names(const std::string &separator, bool yielding)
{
  std::string names;
  for (const LawEntry &entry : law_table())
    if (entry.yields() || !yielding) names += (names.empty() ? "" : separator) + entry.name;
  return names;
}

}    // namespace granwave
