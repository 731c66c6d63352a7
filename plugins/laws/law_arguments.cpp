// SPDX-License-Identifier: GPL-2.0-only
/* Table of the contact laws, and their arguments. */

#include "law_arguments.h"

#include <cstdlib>

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

AnyLaw make_elastoplastic_fe(const LawOptions &o, const LawScales &s)
{
  return ElastoplasticFe(s.first, s.second, s.overlap_per_radius, o.fe_constants);
}

AnyLaw make_thornton(const LawOptions &o, const LawScales &) { return Thornton(o.yield_factor); }

[[noreturn]] void refuse(const std::string &what) { throw std::invalid_argument(what); }

bool is_number(const std::string &word)
{
  char *end = nullptr;
  std::strtod(word.c_str(), &end);
  return !word.empty() && *end == '\0';
}

double number(const std::string &word, const std::string &what)
{
  const double value = is_number(word) ? std::strtod(word.c_str(), nullptr) : INFINITE;
  if (!std::isfinite(value)) refuse(what + " must be a number, found '" + word + "'");
  return value;
}

double positive(const std::string &word, const std::string &what)
{
  const double value = number(word, what);
  if (!(value > 0.0)) refuse(what + " must be positive, found '" + word + "'");
  return value;
}

double not_negative(const std::string &word, const std::string &what)
{
  const double value = number(word, what);
  if (value < 0.0) refuse(what + " must not be negative, found '" + word + "'");
  return value;
}

/* Yield strength; INF for a body that never yields. */
double strength(const std::string &word) { return word == "INF" ? INFINITE : positive(word, "yield strength"); }

double poisson(const std::string &word)
{
  const double value = number(word, "Poisson's ratio");
  if (!(value > -1.0 && value <= 0.5)) refuse("Poisson's ratio must lie in (-1, 0.5], found '" + word + "'");
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
  if (words[at + 2] != "mindlin") model.stiffness = positive(words[at + 2], key + " stiffness");
  model.damping = not_negative(words[at + 3], key + " damping");
  model.coefficient = not_negative(words[at + 4], key + " coefficient");
  if (!model) model = {};
  return 4;
}

}    // namespace

const std::vector<LawEntry> &law_table()
{
  // name, elastic limit, fitted, options, doubles of history beyond the largest overlap; new laws last, since restart files
  // have the number of the line
  static const std::vector<LawEntry> TABLE = {
      {"hertz", INFINITE, false, 0, 0, make_hertz},
      {"elastoplastic", 1.0, true, VARIANT | YIELD_FACTOR | CONSTANTS | RATE, 0, make_elastoplastic},
      {"bilinear", 0.0, false, BETA, 0, make_bilinear},
      {"thornton", 1.0, false, YIELD_FACTOR | RATE, 0, make_thornton},
      {"power", INFINITE, false, POWER, 0, make_hertz},
      {"none", INFINITE, false, 0, 0, make_hertz, true},
      {"elastoplastic-fe", 1.0, true, HARDENING | RATE, 0, make_elastoplastic_fe, false, true},
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
    return Material{positive(words[at], "Young's modulus"), poisson(words[at + 1]),
                    each == 3 ? strength(words[at + 2]) : INFINITE};
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
      args.friction = not_negative(value, key);
    } else if (key == "tangential") {
      args.tangential = tangential_model(value);
    } else if (key == "rolling" || key == "twisting") {
      k += read_slider(words, k, key == "rolling" ? args.resistance.rolling : args.resistance.twisting) - 1;
    } else if (key == "loss") {
      if (value != "time" && value != "dashpot") refuse("loss must be time or dashpot, found '" + value + "'");
      if (args.loss) refuse("loss is given twice: take one of time and dashpot");
      if (k + 2 == words.size()) refuse("'loss " + value + "' has no value; " + usage);
      const double size = not_negative(words[k + 2], "loss " + value);
      if (size > 0.0) args.loss = {value == "time" ? LossKind::TIME : LossKind::DASHPOT, size};
      k++;
    } else if (key == "cohesion") {
      if (value != "jkr" && value != "dmt") refuse("cohesion must be jkr or dmt, found '" + value + "'");
      if (args.options.cohesion) refuse("cohesion is given twice");
      if (k + 2 == words.size()) refuse("'cohesion " + value + "' has no value; " + usage);
      const double energy = not_negative(words[k + 2], "cohesion " + value);
      if (energy > 0.0) args.options.cohesion = {value == "jkr" ? CohesionKind::JKR : CohesionKind::DMT, energy};
      k++;
    } else if (key == "variant" && args.law->takes(VARIANT)) {
      if (value != "continuous" && value != "published")
        refuse("variant must be continuous or published, found '" + value + "'");
      args.options.variant = value == "published" ? Variant::published : Variant::continuous;
    } else if (key == "yield_factor" && args.law->takes(YIELD_FACTOR)) {
      args.options.yield_factor = positive(value, "yield_factor");
    } else if (key == "beta" && args.law->takes(BETA)) {
      args.options.beta = is_number(value) ? std::strtod(value.c_str(), nullptr) : -1.0;
      if (!(args.options.beta >= 0.0 && args.options.beta < 1.0)) refuse("beta must lie in [0, 1), found '" + value + "'");
    } else if (key == "hardening" && args.law->takes(HARDENING)) {
      const auto tangent = [&](const std::string &word) {
        const double found = number(word, key);
        if (!(found >= 0.0 && found < 1.0)) refuse("hardening must lie in [0, 1), found '" + word + "'");
        return found;
      };
      args.first.hardening = tangent(value);
      if (args.second) {
        if (k + 2 == words.size()) refuse("hardening needs a value for each of the two materials; " + usage);
        args.second->hardening = tangent(words[++k + 1]);
      }
    } else if (key == "rate" && args.law->takes(RATE)) {
      k--;
      for (Material *of : {&args.first, args.second ? &*args.second : nullptr}) {
        if (!of) continue;
        if (k + 3 >= words.size()) refuse("rate needs C and a reference rate for each of the materials; " + usage);
        of->rate_sensitivity = not_negative(words[k + 2], "rate sensitivity");
        of->reference_rate = positive(words[k + 3], "reference rate");
        k += 2;
      }
    } else if (key == "constant" && args.law->takes(POWER)) {
      args.options.constant = positive(value, key);
      has_constant = true;
    } else if (key == "exponent" && args.law->takes(POWER)) {
      args.options.exponent = number(value, key);
      if (!(args.options.exponent >= 1.0)) refuse("exponent must be 1 or more, found '" + value + "'");
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
