// SPDX-License-Identifier: GPL-2.0-only
#include "bound_laws.h"

#include "../laws/viscous_loss.h"
#include "arguments.h"

#include <pybind11/stl.h>

#include <string>

namespace py = pybind11;

namespace granwave::bindings {

void bind_laws(py::module_ &module)
{
  py::class_<LawParameter>(module, "LawParameter", "A parameter of contact laws: a number, or one of a list of words.")
      .def_readonly("name", &LawParameter::name)
      .def_readonly("symbol", &LawParameter::symbol, "of its value")
      .def_readonly("keyword", &LawParameter::keyword,
                    "in input scripts; parameters with the same keyword follow it together")
      .def_readonly("description", &LawParameter::description)
      .def_readonly("unit", &LawParameter::unit, "SI; empty if the description states it, or there is none")
      .def_property_readonly("of_material", &LawParameter::is_of_material,
                             "True if each material has a value, False if the contact has one")
      .def_property_readonly("optional", &LawParameter::is_optional, "True if cases omit it unless it is set")
      .def_property_readonly("required", &LawParameter::is_required, "True if laws have no default for it")
      .def_property_readonly(
          "default",
          [](const LawParameter &p) -> py::object {
            return p.is_required() ? py::object(py::none()) : as_python(p, p.fallback);
          },
          "default value: a number or a word; None if it is required")
      .def_property_readonly(
          "example", [](const LawParameter &p) { return as_python(p, p.example); }, "value shown in the documentation")
      .def_property_readonly(
          "words",
          [](const LawParameter &p) {
            py::list words;
            for (int n = 0; n < LawParameter::MOST_WORDS && p.words[n]; n++) words.append(p.words[n]);
            return py::tuple(words);
          },
          "its values, if it is not a number")
      .def_property_readonly(
          "range", [](const LawParameter &p) { return bounds(p.range); },
          "bounds of the law by name: above, at_least, below, at_most")
      .def_property_readonly(
          "case_range", [](const LawParameter &p) { return bounds(p.case_range); }, "bounds of case files, likewise")
      .def("__repr__", [](const LawParameter &p) { return "<LawParameter " + std::string(p.name) + ">"; });
  py::class_<LawEntry>(module, "LawEntry", "A contact law of the table LAWS.")
      .def_readonly("name", &LawEntry::name)
      .def_readonly("elastic_limit", &LawEntry::elastic_limit,
                    "largest overlap without plastic indentation, in alpha_y; infinite: it never yields")
      .def_readonly("fitted", &LawEntry::fitted, "True for a fit, valid to overlaps of 0.2 R*")
      .def_readonly("states_error", &LawEntry::states_error, "True if the law gives error bars")
      .def_property_readonly("yields", &LawEntry::yields, "True if the law needs a yield strength")
      .def_property_readonly("is_power", &LawEntry::is_power,
                             "True for a power of the overlap, or no force at all, whatever the radii")
      .def_property_readonly(
          "parameters",
          [](const LawEntry &entry) {
            py::dict table;
            for (const LawParameter *parameter : entry.parameters)
              table[parameter->name] = py::cast(parameter, py::return_value_policy::reference);
            return table;
          },
          "its parameters, by name, in the order of input scripts");
  using Fe = ElastoplasticFe;
  py::dict range;
  range["poisson_ratio"] = std::pair(0.0, Fe::LARGEST_POISSON);
  range["modulus_over_strength"] = std::pair(Fe::LEAST_RATIO, Fe::LARGEST_RATIO);
  range["hardening"] = std::pair(0.0, Fe::LARGEST_HARDENING);
  module.attr("FE_RANGE") = range;
  py::dict laws;
  for (const LawEntry &entry : law_table()) laws[entry.name] = py::cast(entry, py::return_value_policy::reference);
  module.attr("LAWS") = laws;
  py::dict parameters;
  for (const LawParameter *parameter : law_parameters())
    parameters[parameter->name] = py::cast(parameter, py::return_value_policy::reference);
  module.attr("PARAMETERS") = parameters;
  py::dict of_loss;
  of_loss[TANGENTIAL_LOSS.name] = py::cast(&TANGENTIAL_LOSS, py::return_value_policy::reference);
  module.attr("LOSS_PARAMETERS") = of_loss;
}

}    // namespace granwave::bindings
