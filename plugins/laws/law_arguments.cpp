// SPDX-License-Identifier: GPL-2.0-only
/* Table of the contact laws, and their arguments. */

#include "law_arguments.h"

#include <cstdlib>

namespace granwave {

namespace {

[[noreturn]] void refuse(const std::string &what) { throw std::invalid_argument(what); }

bool is_number(const std::string &word)
{
  char *end = nullptr;
  std::strtod(word.c_str(), &end);
  return !word.empty() && *end == '\0';
}

/* Values that a number may have, and what a message says that it must. */
struct Range {
  bool (*holds)(double);
  const char *must;
};

constexpr Range FINITE = {[](double) { return true; }, "be a number"};
constexpr Range POSITIVE = {[](double value) { return value > 0.0; }, "be positive"};
constexpr Range NOT_NEGATIVE = {[](double value) { return value >= 0.0; }, "not be negative"};
constexpr Range AT_LEAST_ONE = {[](double value) { return value >= 1.0; }, "be 1 or more"};
constexpr Range SHARE = {[](double value) { return value >= 0.0 && value < 1.0; }, "lie in [0, 1)"};
constexpr Range POISSON = {[](double value) { return value > -1.0 && value <= 0.5; }, "lie in (-1, 0.5]"};

double number(const std::string &word, const std::string &what, const Range &range = FINITE)
{
  const double value = is_number(word) ? std::strtod(word.c_str(), nullptr) : INFINITE;
  const bool finite = std::isfinite(value);
  if (!finite || !range.holds(value)) refuse(what + " must " + (finite ? range : FINITE).must + ", found '" + word + "'");
  return value;
}

/* Read a resistance to rolling or twisting. Returns the number of words after the key at `at`. */
std::size_t read_slider(const std::vector<std::string> &words, std::size_t at, SliderModel &model)
{
  const std::string &key = words[at], &kind = words[at + 1];
  if (model) refuse(key + " is given twice");
  model.marshall = key == "twisting" && kind == "marshall";
  if (model.marshall) return 1;
  const std::string form = key + " sds K|mindlin GAMMA MU" + (key == "twisting" ? " or twisting marshall" : "");
  if (kind != "sds") refuse("expected " + form + ", found '" + key + " " + kind + "'");
  if (at + 4 >= words.size()) refuse("'" + key + " sds' has too few values; expected " + form);
  if (words[at + 2] != "mindlin") model.stiffness = number(words[at + 2], key + " stiffness", POSITIVE);
  model.damping = number(words[at + 3], key + " damping", NOT_NEGATIVE);
  model.coefficient = number(words[at + 4], key + " coefficient", NOT_NEGATIVE);
  if (!model) model = {};
  return 4;
}

}    // namespace

const std::vector<LawEntry> &law_table()
{
  // name, elastic limit, fitted, options, doubles of history beyond the largest overlap; new laws last, since restart files
  // have the number of the line
  using Options = const LawOptions &;
  using Scales = const LawScales &;
  const auto hertz = [](Options, Scales) -> AnyLaw { return Hertz(); };
  const auto elastoplastic = [](Options o, Scales) -> AnyLaw {
    return Elastoplastic(o.variant, o.yield_factor, o.constants);
  };
  const auto bilinear = [](Options o, Scales s) -> AnyLaw {
    return Bilinear(Bilinear::STIFFNESS * s.yield_strength * s.overlap_per_radius / s.force_per_area, o.beta);
  };
  const auto thornton = [](Options o, Scales) -> AnyLaw { return Thornton(o.yield_factor); };
  const auto elastoplastic_fe = [](Options o, Scales s) -> AnyLaw {
    return ElastoplasticFe(s.first, s.second, s.overlap_per_radius, o.fe_constants);
  };
  static const std::vector<LawEntry> TABLE = {
      {"hertz", INFINITE, false, 0, 0, hertz},
      {"elastoplastic", 1.0, true, VARIANT | YIELD_FACTOR | CONSTANTS | RATE, 0, elastoplastic},
      {"bilinear", 0.0, false, BETA, 0, bilinear},
      {"thornton", 1.0, false, YIELD_FACTOR | RATE, 0, thornton},
      {"power", INFINITE, false, POWER, 0, hertz},
      {"none", INFINITE, false, 0, 0, hertz, true},
      {"elastoplastic-fe", 1.0, true, HARDENING | RATE, 0, elastoplastic_fe, false, true, true},
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

double LawConstants::*law_constant(const std::string &name)
{
  for (const auto &[known, member] : LAW_CONSTANTS)
    if (name == known) return member;
  return nullptr;
}

TangentialModel tangential_model(const std::string &name)
{
  if (name == "mindlin_rescale") return TangentialModel::MINDLIN_RESCALE;
  if (name == "mindlin") return TangentialModel::MINDLIN;
  if (name == "partial_slip") return TangentialModel::PARTIAL_SLIP;
  refuse("tangential must be mindlin_rescale, mindlin or partial_slip, found '" + name + "'");
}

LawArguments parse_law(const std::vector<std::string> &words)
{
  const std::string usage =
      "expected: hertz|none E nu [E2 nu2], power E nu [E2 nu2] constant K exponent p, or " + law_names("|", true) +
      " E nu sigma_y "
      "[E2 nu2 sigma_y2], then [friction mu] [tangential mindlin_rescale|mindlin|partial_slip] "
      "[rolling sds K|mindlin gamma mu] [twisting sds K|mindlin gamma mu|marshall] "
      "[loss time A|dashpot alpha] [cohesion jkr|dmt w] [variant continuous|published] [yield_factor C] "
      "[beta b] [hardening h [h2]] [rate C r0 [C2 r02]], and for elastoplastic its constants "
      "[pressure_limit x] [pressure_rate x] ...";
  if (words.empty()) refuse("no contact law; " + usage);
  LawArguments args;
  args.words = words;
  args.law = find_law(words[0]);
  if (!args.law) refuse("unknown contact law '" + words[0] + "'; " + usage);

  std::size_t numbers = 0;
  while (1 + numbers < words.size() && is_number(words[1 + numbers])) numbers++;
  const std::size_t each = args.law->yields() ? 3 : 2;
  if (numbers != each && numbers != 2 * each)
    refuse("law '" + words[0] + "' has " + std::to_string(numbers) + " material constants; " + usage);
  const auto material = [&](std::size_t at) {
    const bool yields = each == 3 && words[at + 2] != "INF";
    return Material{number(words[at], "Young's modulus", POSITIVE), number(words[at + 1], "Poisson's ratio", POISSON),
                    yields ? number(words[at + 2], "yield strength", POSITIVE) : INFINITE};
  };
  args.first = material(1);
  if (numbers == 2 * each) args.second = material(1 + each);
  if (each == 3 && !std::isfinite(std::min(args.first.yield_strength, args.second.value_or(args.first).yield_strength)))
    refuse("law '" + words[0] + "' needs a yield strength for one of the two bodies; if none yields, take law hertz");

  bool given = false, has_constant = false, has_exponent = false;    // true if a constant of the law, K or p are given
  for (std::size_t k = 1 + numbers; k < words.size(); k += 2) {
    const std::string &key = words[k];
    if (k + 1 == words.size()) refuse("'" + key + "' has no value; " + usage);
    const std::string &value = words[k + 1];
    if (key == "friction") {
      args.friction = number(value, key, NOT_NEGATIVE);
    } else if (key == "tangential") {
      args.tangential = tangential_model(value);
    } else if (key == "rolling" || key == "twisting") {
      k += read_slider(words, k, key == "rolling" ? args.resistance.rolling : args.resistance.twisting) - 1;
    } else if (key == "loss" || key == "cohesion") {
      const bool loss = key == "loss", first = value == (loss ? "time" : "jkr");
      if (!first && value != (loss ? "dashpot" : "dmt"))
        refuse(key + " must be " + (loss ? "time or dashpot" : "jkr or dmt") + ", found '" + value + "'");
      if (loss ? bool(args.loss) : bool(args.options.cohesion)) refuse(key + " is given twice");
      if (++k + 1 == words.size()) refuse("'" + key + " " + value + "' has no value; " + usage);
      const double size = number(words[k + 1], key + " " + value, NOT_NEGATIVE);
      if (size > 0.0 && loss) args.loss = {first ? LossKind::TIME : LossKind::DASHPOT, size};
      if (size > 0.0 && !loss) args.options.cohesion = {first ? CohesionKind::JKR : CohesionKind::DMT, size};
    } else if (key == "variant" && args.law->takes(VARIANT)) {
      if (value != "continuous" && value != "published")
        refuse("variant must be continuous or published, found '" + value + "'");
      args.options.variant = value == "published" ? Variant::published : Variant::continuous;
    } else if (key == "yield_factor" && args.law->takes(YIELD_FACTOR)) {
      args.options.yield_factor = number(value, key, POSITIVE);
    } else if (key == "beta" && args.law->takes(BETA)) {
      args.options.beta = number(value, key, SHARE);
    } else if (key == "hardening" && args.law->takes(HARDENING)) {
      args.first.hardening = number(value, key, SHARE);
      if (args.second) {
        if (++k + 1 == words.size()) refuse("hardening needs a value for each of the two materials; " + usage);
        args.second->hardening = number(words[k + 1], key, SHARE);
      }
    } else if (key == "rate" && args.law->takes(RATE)) {
      k--;
      for (Material *of : {&args.first, args.second ? &*args.second : nullptr}) {
        if (!of) continue;
        if (k + 3 >= words.size()) refuse("rate needs C and a reference rate for each of the materials; " + usage);
        of->rate_sensitivity = number(words[k + 2], "rate sensitivity", NOT_NEGATIVE);
        of->reference_rate = number(words[k + 3], "reference rate", POSITIVE);
        k += 2;
      }
    } else if (key == "constant" && args.law->takes(POWER)) {
      args.options.constant = number(value, key, POSITIVE);
      has_constant = true;
    } else if (key == "exponent" && args.law->takes(POWER)) {
      args.options.exponent = number(value, key, AT_LEAST_ONE);
      has_exponent = true;
    } else if (const auto constant = law_constant(key); constant && args.law->takes(CONSTANTS)) {
      args.options.constants.*constant = number(value, key);
      given = true;
    } else {
      refuse("'" + key + "' is no option of law '" + words[0] + "'; " + usage);
    }
  }
  if (args.resistance.twisting.marshall && !(args.friction > 0.0))
    refuse("twisting marshall resists by the friction of the contact, which is 0: give friction mu");
  if (args.options.cohesion && args.law->is_power())
    refuse("law '" + words[0] + "' has no contact circle, which cohesion needs: take law hertz");
  if (args.options.cohesion && args.has_rate())
    refuse("cohesion holds for a yield strength that does not depend on the rate: leave out cohesion or rate");
  if (args.options.cohesion.kind == CohesionKind::JKR && args.law->yields())
    refuse("cohesion jkr is of elastic spheres: take law hertz, or cohesion dmt with law '" + words[0] + "'");
  if (args.law->takes(POWER) && !(has_constant && has_exponent))
    refuse("law power needs constant K and exponent p; " + usage);
  if (args.has_rate() && args.options.variant == Variant::published)
    refuse("rate needs a law that is passive: variant continuous");
  if (given && args.options.variant == Variant::published)
    refuse("variant published has constants of its own: take one or the other");
  if (const std::string fault = given ? args.contact(args.first, args.first).fault() : ""; !fault.empty())
    refuse("these constants make no passive law: " + fault);
  return args;
}

}    // namespace granwave
