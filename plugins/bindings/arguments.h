// SPDX-License-Identifier: GPL-2.0-only
/* Arguments of the bindings: checks, and parameters of laws as values of Python. */

#ifndef GRANWAVE_BINDINGS_ARGUMENTS_H
#define GRANWAVE_BINDINGS_ARGUMENTS_H

#include "../laws/law_arguments.h"

#include <pybind11/pybind11.h>

#include <string>
#include <utility>

namespace granwave::bindings {

using Two = std::pair<double, double>;    // values of the first and the second body

/* Raise ValueError of Python with this fault unless a condition holds. */
void require(bool holds, const std::string &fault);

std::pair<Material, Material> elastic_bodies(Two modulus, Two poisson);

/* Value of a parameter in Python: a number or a word. */
pybind11::object as_python(const LawParameter &parameter, double value);

/* Value of a parameter from Python; ValueError if it is out of range, or not a word of the parameter. */
double from_python(const LawParameter &parameter, pybind11::handle object);

/* Bounds of a range, by their names in the schema of case files. */
pybind11::dict bounds(const Range &range);

/* Constants of the curve of a law, by name. */
pybind11::dict constants_of(const LawEntry &entry, const LawValues &values);

/* Parameter of any law by its name; null without one. */
const LawParameter *find_parameter(const std::string &name);

/* Law of this name; ValueError if there is none. */
const LawEntry &known_law(const std::string &name);

}    // namespace granwave::bindings

#endif
