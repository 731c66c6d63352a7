// SPDX-License-Identifier: GPL-2.0-only
#include "arguments.h"

#include <cmath>

namespace py = pybind11;

namespace granwave::bindings {

void require(bool holds, const std::string &fault)
{
  if (!holds) throw py::value_error(fault);
}

std::pair<Material, Material> elastic_bodies(Two modulus, Two poisson)
{
  return {{modulus.first, poisson.first, INFINITE}, {modulus.second, poisson.second, INFINITE}};
}

py::object as_python(const LawParameter &parameter, double value)
{
  if (parameter.is_word()) return py::str(parameter.words[static_cast<std::size_t>(value)]);
  return py::float_(value);
}

double from_python(const LawParameter &parameter, py::handle object)
{
  const std::string name(parameter.name);
  if (!parameter.is_word()) {
    const double value = object.cast<double>();
    require(std::isfinite(value), name + " must be a finite number");
    require(parameter.range.holds(value), name + " must " + must(parameter.range));
    return value;
  }
  const std::string word = object.cast<std::string>();
  const int value = parameter.number_of(word);
  require(value >= 0, name + " must be " + parameter.all_words(" or ") + ", found '" + word + "'");
  return value;
}

py::dict bounds(const Range &range)
{
  const auto plain = [](double bound) {    // 1, not 1.0
    return bound == std::floor(bound) ? py::object(py::int_(static_cast<long>(bound))) : py::object(py::float_(bound));
  };
  py::dict keywords;
  if (std::isfinite(range.low)) keywords[range.with_low ? "at_least" : "above"] = plain(range.low);
  if (std::isfinite(range.high)) keywords[range.with_high ? "at_most" : "below"] = plain(range.high);
  return keywords;
}

py::dict constants_of(const LawEntry &entry, const LawValues &values)
{
  py::dict constants;
  for (const LawParameter *parameter : entry.parameters)
    if (parameter->is_optional() && !parameter->is_of_material())
      constants[parameter->name] = as_python(*parameter, values[*parameter]);
  return constants;
}

const LawParameter *find_parameter(const std::string &name)
{
  for (const LawParameter *parameter : law_parameters())
    if (name == parameter->name) return parameter;
  return nullptr;
}

const LawEntry &known_law(const std::string &name)
{
  const LawEntry *const entry = find_law(name);
  require(entry, "law must be one of " + law_names(", ") + ", found '" + name + "'");
  return *entry;
}

}    // namespace granwave::bindings
