// SPDX-License-Identifier: GPL-2.0-only
/* Parameters of the contact laws, and their values. A parameter is defined once, as a constant in the header of its law,
   with name, range, default, unit and description; a law lists its own in the table of laws (law_arguments.cpp). Keywords
   of input scripts, arguments of the Python binding, keys of case files and the tables of the manual follow. No LAMMPS
   types.

       inline constexpr LawParameter BETA =
           LawParameter("beta", "b", "residual overlap over the largest overlap").in({0.0, 1.0, true}).usually(0.8);

   A law reads its values in its constructor: `values[BETA]` of a contact, `material[HARDENING]` of a material. */

#ifndef GRANWAVE_LAW_PARAMETERS_H
#define GRANWAVE_LAW_PARAMETERS_H

#include <array>
#include <cstdio>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace granwave {

constexpr double INFINITE = std::numeric_limits<double>::infinity();

/* Interval of numbers. */
struct Range {
  double low = -INFINITE, high = INFINITE;
  bool with_low = false, with_high = false;    // true if the interval contains the bound

  constexpr bool holds(double value) const
  {
    return (value > low || (with_low && value == low)) && (value < high || (with_high && value == high));
  }
};

constexpr Range ANY_NUMBER = {};
constexpr Range POSITIVE = {0.0};
constexpr Range NOT_NEGATIVE = {0.0, INFINITE, true};
constexpr Range AT_LEAST_ONE = {1.0, INFINITE, true};
constexpr Range BELOW_ONE = {0.0, 1.0, true};    // from 0

/* Requirement of a range in messages: "be positive". */
inline std::string must(const Range &range)
{
  const auto text = [](const char *form, double a, double b = 0.0) {
    char words[80];
    std::snprintf(words, sizeof words, form, a, b);
    return std::string(words);
  };
  const bool has_low = range.low > -INFINITE, has_high = range.high < INFINITE;
  if (has_low && has_high)
    return (range.with_low ? "lie in [" : "lie in (") + text("%g, %g", range.low, range.high) +
           (range.with_high ? "]" : ")");
  if (has_high) return text(range.with_high ? "be %g or less" : "be below %g", range.high);
  if (has_low && range.low == 0.0) return range.with_low ? "not be negative" : "be positive";
  return has_low ? text(range.with_low ? "be %g or more" : "be above %g", range.low) : "be a number";
}

/* A parameter of a law: a number, or a word, which is stored as its number. */
struct LawParameter {
  enum class Holder { CONTACT, MATERIAL };    // tables of a case: [contact], or each [material]
  enum class Presence { USUAL, OPTIONAL, REQUIRED };

  static constexpr int MOST_WORDS = 4;

  const char *name;           // key of case files and argument in Python
  const char *symbol;         // symbol of its value, in the usage and the manual
  const char *description;    // description of the key, in case files
  const char *keyword;        // keyword in input scripts; parameters with the same keyword follow it together
  const char *unit = "";      // SI unit; none: the description states it, or there is none
  Holder holder = Holder::CONTACT;
  Presence presence = Presence::USUAL;
  double fallback = 0.0;    // default value
  double example = 0.0;     // value shown in the documentation
  Range range;              // range in which the law is valid
  Range case_range;         // range accepted in case files
  std::array<const char *, MOST_WORDS> words{};

  constexpr LawParameter(const char *name, const char *symbol, const char *description) :
      name(name), symbol(symbol), description(description), keyword(name)
  {
  }

  /* ---- these functions return a copy with a further property */

  constexpr LawParameter in(const Range &numbers) const
  {
    LawParameter p(*this);
    p.range = p.case_range = numbers;
    return p;
  }
  /* Limit case files to a smaller range than the law. */
  constexpr LawParameter in_cases(const Range &numbers) const
  {
    LawParameter p(*this);
    p.case_range = numbers;
    return p;
  }
  constexpr LawParameter one_of(const std::array<const char *, MOST_WORDS> &names) const
  {
    LawParameter p(*this);
    p.words = names;
    return p;
  }
  constexpr LawParameter in_units(const char *name) const
  {
    LawParameter p(*this);
    p.unit = name;
    return p;
  }
  /* Write it in every case and input script. */
  constexpr LawParameter usually(double value) const { return with(Presence::USUAL, value, value); }
  /* Omit it from them unless it is set; the example is another value if the default has no effect. */
  constexpr LawParameter optional(double value) const { return with(Presence::OPTIONAL, value, value); }
  constexpr LawParameter optional(double value, double shown) const { return with(Presence::OPTIONAL, value, shown); }
  constexpr LawParameter required(double shown) const { return with(Presence::REQUIRED, 0.0, shown); }
  constexpr LawParameter of_material() const
  {
    LawParameter p(*this);
    p.holder = Holder::MATERIAL;
    return p;
  }
  constexpr LawParameter after(const char *word) const
  {
    LawParameter p(*this);
    p.keyword = word;
    return p;
  }

  /* ---- */

  bool operator==(const LawParameter &other) const { return std::string_view(name) == other.name; }
  constexpr bool is_of_material() const { return holder == Holder::MATERIAL; }
  constexpr bool is_optional() const { return presence == Presence::OPTIONAL; }
  constexpr bool is_required() const { return presence == Presence::REQUIRED; }
  constexpr bool is_word() const { return words[0]; }

  /* Number of a word; -1 for other words. */
  int number_of(std::string_view word) const
  {
    for (int n = 0; n < MOST_WORDS && words[n]; n++)
      if (word == words[n]) return n;
    return -1;
  }
  /* All words, joined. */
  std::string all_words(const char *separator) const
  {
    std::string text;
    for (int n = 0; n < MOST_WORDS && words[n]; n++) text += (n > 0 ? separator : "") + std::string(words[n]);
    return text;
  }
  /* Its name in messages about input scripts. */
  std::string title() const
  {
    std::string text(name);
    if (text != keyword)
      for (char &letter : text)
        if (letter == '_') letter = ' ';
    return text;
  }

 private:
  constexpr LawParameter with(Presence present, double value, double shown) const
  {
    LawParameter p(*this);
    p.presence = present;
    p.fallback = value;
    p.example = shown;
    return p;
  }
};

/* Values of parameters; missing values are the defaults. */
class LawValues {
 public:
  double operator[](const LawParameter &parameter) const
  {
    for (const auto &[own, value] : set_)
      if (*own == parameter) return value;
    return parameter.fallback;
  }
  bool has(const LawParameter &parameter) const
  {
    for (const auto &[own, value] : set_)
      if (*own == parameter) return true;
    return false;
  }
  /* Set the value of a parameter, which must outlive this object. */
  void set(const LawParameter &parameter, double value)
  {
    for (auto &[own, old] : set_)
      if (*own == parameter) {
        old = value;
        return;
      }
    set_.emplace_back(&parameter, value);
  }
  bool operator==(const LawValues &other) const { return agrees(other) && other.agrees(*this); }

 private:
  std::vector<std::pair<const LawParameter *, double>> set_;

  bool agrees(const LawValues &other) const
  {
    for (const auto &[parameter, value] : set_)
      if (other[*parameter] != value) return false;
    return true;
  }
};

}    // namespace granwave

#endif
