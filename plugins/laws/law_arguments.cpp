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

constexpr Range POISSON = {-1.0, 0.5, false, true};

double number(const std::string &word, const std::string &what, const Range &range = ANY_NUMBER)
{
  const double value = is_number(word) ? std::strtod(word.c_str(), nullptr) : INFINITE;
  const bool finite = std::isfinite(value);
  if (!finite || !range.holds(value)) refuse(what + " must " + must(finite ? range : ANY_NUMBER) + ", found '" + word + "'");
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

/* Read the branches of a Prony series, "g1 tau1 g2 tau2 ...". Returns the number of words after the two at `at`. */
std::size_t read_series(const std::vector<std::string> &words, std::size_t at, ViscousLoss &loss)
{
  std::size_t count = 0;
  while (at + 2 + count < words.size() && is_number(words[at + 2 + count])) count++;
  const std::string most = std::to_string(PronySeries::MOST);
  if (count == 0 || count % 2 == 1 || count > 2 * PronySeries::MOST)
    refuse("loss prony needs a weight and a time for each of 1 to " + most + " branches, found " + std::to_string(count) +
           (count == 1 ? " number" : " numbers"));
  PronySeries &series = loss.prony;
  series.n = static_cast<int>(count / 2);
  for (int i = 0; i < series.n; i++) {
    series.weight[i] = number(words[at + 2 + 2 * i], "weight of loss prony", BELOW_ONE);
    series.time[i] = number(words[at + 3 + 2 * i], "time of loss prony", POSITIVE);
  }
  if (!(series.remains() > 0.0)) refuse("the weights of loss prony must sum to less than 1");
  loss.kind = LossKind::PRONY;
  return count;
}

/* Return the reason why a contact cannot relax; empty if it can. */
void refuse_relaxing(const LawArguments &args, const std::string &name)
{
  if (!args.loss.relaxes()) return;
  if (args.law->yields())
    refuse("loss prony requires an elastic law, found '" + name + "', which yields: use law hertz, or loss time or dashpot");
  if (args.options.cohesion) refuse("loss prony requires contacts without cohesion: remove cohesion or loss");
  if (args.loss.tangential > 0.0)
    refuse(TANGENTIAL_LOSS.keyword + std::string(" is a factor of a damping coefficient, which loss prony does not have: "
                                                 "use loss time or loss dashpot"));
}

/* Value of a parameter from its word. */
double value_of(const LawParameter &parameter, const std::string &word)
{
  if (!parameter.is_word()) return number(word, parameter.title(), parameter.range);
  const int value = parameter.number_of(word);
  if (value < 0) refuse(parameter.title() + " must be " + parameter.all_words(" or ") + ", found '" + word + "'");
  return value;
}

std::string symbols(const std::vector<const LawParameter *> &parameters, const std::string &separator,
                    const char *suffix = "")
{
  std::string text;
  for (const LawParameter *parameter : parameters)
    text +=
        (text.empty() ? "" : separator) + (parameter->is_word() ? parameter->all_words("|") : parameter->symbol) + suffix;
  return text;
}

/* Read the values of parameters with one keyword: of a contact once, of materials once for each. Returns the number of words
   after the keyword at `at`. */
std::size_t read_values(const std::vector<std::string> &words, std::size_t at,
                        const std::vector<const LawParameter *> &parameters, LawArguments &args, const std::string &usage)
{
  const bool of_material = parameters.front()->is_of_material();
  std::vector<LawValues *> holders{of_material ? &args.first.values : &args.options.values};
  if (of_material && args.second) holders.push_back(&args.second->values);
  const std::size_t count = holders.size() * parameters.size();
  if (at + count >= words.size())
    refuse(words[at] + " needs " +
           (parameters.size() == 1 ? "a value for each of the two materials"
                                   : symbols(parameters, " and ") + " for each of the materials") +
           "; " + usage);
  for (LawValues *values : holders)
    for (const LawParameter *parameter : parameters) values->set(*parameter, value_of(*parameter, words[++at]));
  return count;
}

/* "constant K exponent p" of the parameters that a law requires; empty if there are none. */
std::string required_words(const LawEntry &law, const std::string &separator)
{
  std::string text;
  for (const LawParameter *parameter : law.parameters)
    if (parameter->is_required())
      text += (text.empty() ? "" : separator) + std::string(parameter->keyword) + " " + parameter->symbol;
  return text;
}

/* "[rate C r0 [C2 r02]]" of the other parameters of all laws. */
std::string optional_words()
{
  std::string text, last;
  for (const LawParameter *parameter : law_parameters()) {
    if (parameter->is_required() || last == parameter->keyword) continue;
    last = parameter->keyword;
    std::vector<const LawParameter *> alike;
    for (const LawParameter *other : law_parameters())
      if (last == other->keyword) alike.push_back(other);
    text += " [" + last + " " + symbols(alike, " ");
    text += parameter->is_of_material() ? " [" + symbols(alike, " ", "2") + "]]" : "]";
  }
  return text;
}

std::string usage_of_laws()
{
  std::string elastic, powers;
  for (const LawEntry &entry : law_table()) {
    if (entry.yields()) continue;
    const std::string required = required_words(entry, " ");
    if (required.empty()) elastic += (elastic.empty() ? "" : "|") + std::string(entry.name);
    else powers += std::string(entry.name) + " E nu [E2 nu2] " + required + ", ";
  }
  return "expected: " + elastic + " E nu [E2 nu2], " + powers + "or " + law_names("|", true) +
         " E nu sigma_y [E2 nu2 sigma_y2], then [friction mu] [tangential mindlin_rescale|mindlin|partial_slip] "
         "[rolling sds K|mindlin gamma mu] [twisting sds K|mindlin gamma mu|marshall] "
         "[loss time A|dashpot alpha [" +
         TANGENTIAL_LOSS.keyword + " " + TANGENTIAL_LOSS.symbol + "]|prony g1 tau1 ...] [cohesion jkr|dmt w]" +
         optional_words();
}

/* Law from the values of its parameters and the scales of the pair. */
template <class Law> AnyLaw make(const LawOptions &options, const LawScales &scales) { return Law(options.values, scales); }

AnyLaw make_hertz(const LawOptions &, const LawScales &) { return Hertz(); }

AnyLaw make_elastoplastic_fe(const LawOptions &options, const LawScales &scales)
{
  return ElastoplasticFe(scales.first, scales.second, scales.overlap_per_radius, options.fe_constants);
}

}    // namespace

const std::vector<LawEntry> &law_table()
{
  // new laws last, since restart files have the number of the line
  static const std::vector<LawEntry> TABLE = {
      LawEntry("hertz", make_hertz),
      LawEntry("elastoplastic", make<Elastoplastic>)
          .yielding_beyond(1.0)
          .fit()
          .with({&VARIANT, &YIELD_FACTOR, &RATE_SENSITIVITY, &REFERENCE_RATE, &PRESSURE_LIMIT, &PRESSURE_RATE, &AREA_SWITCH,
                 &AREA_SLOPE, &AREA_OFFSET, &RESIDUAL_SLOPE, &RESIDUAL_OFFSET, &RESIDUAL_RATE, &UNLOADING_EXPONENT})
          .excluding(Elastoplastic::conflict),
      LawEntry("bilinear", make<Bilinear>).yielding_beyond(0.0).with({&BETA}),
      LawEntry("thornton", make<Thornton>).yielding_beyond(1.0).with({&YIELD_FACTOR, &RATE_SENSITIVITY, &REFERENCE_RATE}),
      LawEntry("power", make_hertz).with({&POWER_CONSTANT, &POWER_EXPONENT}),
      LawEntry("none", make_hertz).without_force(),
      LawEntry("elastoplastic-fe", make_elastoplastic_fe)
          .yielding_beyond(1.0)
          .fit()
          .yielding_exactly()
          .with_error_bars()
          .with({&HARDENING, &RATE_SENSITIVITY, &REFERENCE_RATE}),
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

std::vector<const LawParameter *> law_parameters()
{
  std::vector<const LawParameter *> all;
  for (const LawEntry &entry : law_table())
    for (const LawParameter *parameter : entry.parameters)
      if (std::none_of(all.begin(), all.end(), [&](const LawParameter *other) { return *other == *parameter; }))
        all.push_back(parameter);
  return all;
}

std::vector<const LawParameter *> LawEntry::with_keyword(const std::string &keyword) const
{
  std::vector<const LawParameter *> alike;
  for (const LawParameter *parameter : parameters)
    if (keyword == parameter->keyword) alike.push_back(parameter);
  return alike;
}

bool LawEntry::has_constants(const LawValues &values) const
{
  return std::any_of(parameters.begin(), parameters.end(), [&](const LawParameter *own) {
    return own->is_optional() && !own->is_of_material() && values.has(*own);
  });
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
  const std::string usage = usage_of_laws();
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
    refuse("law '" + words[0] + "' needs a yield strength for one of the two bodies; if neither yields, use law hertz");

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
      const bool prony = loss && value == "prony";
      if (!first && !prony && value != (loss ? "dashpot" : "dmt"))
        refuse(key + " must be " + (loss ? "time, dashpot or prony" : "jkr or dmt") + ", found '" + value + "'");
      if (loss ? bool(args.loss) : bool(args.options.cohesion)) refuse(key + " is given twice");
      if (prony) {
        k += read_series(words, k, args.loss);
        continue;
      }
      if (++k + 1 == words.size()) refuse("'" + key + " " + value + "' has no value; " + usage);
      const double size = number(words[k + 1], key + " " + value, NOT_NEGATIVE);
      if (size > 0.0 && loss) {
        args.loss.kind = first ? LossKind::TIME : LossKind::DASHPOT;
        args.loss.value = size;
      }
      if (size > 0.0 && !loss) args.options.cohesion = {first ? CohesionKind::JKR : CohesionKind::DMT, size};
    } else if (key == TANGENTIAL_LOSS.keyword) {
      args.loss.tangential = number(value, key, TANGENTIAL_LOSS.range);
    } else if (const auto parameters = args.law->with_keyword(key); !parameters.empty()) {
      k += read_values(words, k, parameters, args, usage) - 1;
    } else {
      refuse("'" + key + "' is not an option of law '" + words[0] + "'; " + usage);
    }
  }
  if (args.resistance.twisting.marshall && !(args.friction > 0.0))
    refuse("twisting marshall depends on the friction of the contact, which is 0: set friction mu");
  refuse_relaxing(args, words[0]);
  if (args.loss.tangential > 0.0 && !args.loss)
    refuse(TANGENTIAL_LOSS.keyword +
           std::string(" is a factor of the normal damping, which is 0: set loss time A or loss dashpot alpha"));
  if (args.loss.tangential > 0.0 && !(args.friction > 0.0))
    refuse(TANGENTIAL_LOSS.keyword + std::string(" is limited by friction, which is 0: set friction mu"));
  if (args.options.cohesion && args.law->is_power())
    refuse("law '" + words[0] + "' has no contact circle, which cohesion requires: use law hertz");
  if (args.options.cohesion && args.has_rate())
    refuse("cohesion requires a rate-independent yield strength: remove cohesion or rate");
  if (args.options.cohesion.kind == CohesionKind::JKR && args.law->yields())
    refuse("cohesion jkr requires elastic spheres: use law hertz, or cohesion dmt with law '" + words[0] + "'");
  const LawValues &values = args.options.values;
  for (const LawParameter *parameter : args.law->parameters)
    if (parameter->is_required() && !values.has(*parameter))
      refuse("law " + words[0] + " needs " + required_words(*args.law, " and ") + "; " + usage);
  if (const std::string conflict = args.law->conflict_of(values, args.has_rate()); !conflict.empty()) refuse(conflict);
  if (!args.law->has_constants(values)) return args;
  if (const std::string fault = args.contact(args.first, args.first).fault(); !fault.empty())
    refuse("these constants do not give a passive law: " + fault);
  return args;
}

}    // namespace granwave
