// SPDX-License-Identifier: GPL-2.0-only
/* Python module `granwave._number_reader`: fast reading of numbers in the text files that LAMMPS writes. */

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>
#include <vector>

namespace py = pybind11;

namespace {

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

/* Read numbers separated by white space, each rounded to the nearest double; None if there is anything else, or a number
   that is not finite. */
py::object read_numbers(std::string_view text)
{
  std::vector<double> numbers;
  numbers.reserve(text.size() / 8);
  const char *at = text.data(), *const end = at + text.size();
  while (true) {
    while (at != end && is_space(*at)) at++;
    if (at == end) break;
    if (*at == '+') at++;
    double number;
    const auto [after, fault] = std::from_chars(at, end, number);
    if (fault != std::errc() || !std::isfinite(number) || (after != end && !is_space(*after))) return py::none();
    numbers.push_back(number);
    at = after;
  }
  return py::array_t<double>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}

}    // namespace

PYBIND11_MODULE(_number_reader, module)
{
  module.doc() = "Numbers in text.";
  module.def("read_numbers", &read_numbers, py::arg("text"),
             "Numbers of a text, separated by white space, as an array; None if it contains anything else.");
}
