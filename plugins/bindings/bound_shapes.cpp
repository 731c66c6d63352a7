// SPDX-License-Identifier: GPL-2.0-only
#include "bound_shapes.h"

#include "../laws/cylinders.h"
#include "arguments.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace py = pybind11;

namespace granwave::bindings {

void bind_shapes(py::module_ &module)
{
  const py::arg overlap("overlap");
  py::class_<LineContact>(module, "LineContact",
                          "Contact along a line: a cylinder on a plane, or two parallel cylinders.\n\n"
                          "Pairs are (first, second) body, rigid where the modulus is inf. SI units.")
      .def(py::init([](Two modulus, Two poisson, double diameter, double length) {
             require(diameter > 0.0 && length > 0.0, "diameter and length must be positive");
             const auto [first, second] = elastic_bodies(modulus, poisson);
             return LineContact(first, second, diameter, length);
           }),
           py::kw_only(), py::arg("youngs_modulus"), py::arg("poisson_ratio"), py::arg("diameter"), py::arg("length"))
      .def_static(
          "plane_strain",
          [](Two modulus, Two poisson, Two radius, double length) {
            require(radius.first > 0.0 && radius.second > 0.0 && length > 0.0, "radii and length must be positive");
            require(std::isfinite(radius.first) || std::isfinite(radius.second),
                    "at least one of the two bodies must be a cylinder, found two planes");
            const auto [first, second] = elastic_bodies(modulus, poisson);
            return LineContact::plane_strain(first, second, radius.first, radius.second, length);
          },
          py::kw_only(), py::arg("youngs_modulus"), py::arg("poisson_ratio"), py::arg("radius"), py::arg("length"),
          "Contact in plane strain after Johnson; a plane has the radius inf.")
      .def_property_readonly("largest_overlap", &LineContact::largest_overlap, "end of the law, m")
      .def("force", py::vectorize(&LineContact::force), overlap, "Force at an overlap, N.")
      .def("stiffness", py::vectorize(&LineContact::stiffness), overlap, "Slope of the force over the overlap, N/m.")
      .def("energy", py::vectorize(&LineContact::energy), overlap, "Stored energy, J.");
  using Axis = std::array<double, 3>;
  py::class_<CylinderPair>(module, "CylinderPair",
                           "Two bodies, one of them a cylinder at least; a sphere has the length 0. SI units.")
      .def(py::init([](Two length, const Axis &first, const Axis &second) {
             Cylinder one{length.first, {}}, other{length.second, {}};
             std::copy(first.begin(), first.end(), one.axis);
             std::copy(second.begin(), second.end(), other.axis);
             require(!one.is_sphere() || !other.is_sphere(), "at least one of the two bodies must be a cylinder");
             return CylinderPair(one, other);
           }),
           py::kw_only(), py::arg("length"), py::arg("first_axis"), py::arg("second_axis"))
      .def_property_readonly("parallel", &CylinderPair::parallel, "True if they touch along a line")
      .def_property_readonly("nearly_parallel", &CylinderPair::nearly_parallel,
                             "True if they cross at an angle too small for any law")
      .def_property_readonly("length", &CylinderPair::length, "length of this line, m")
      .def("effective_radius", &CylinderPair::effective_radius, py::arg("first"), py::arg("second"),
           "Radius of the sphere that is as stiff on a plane, from both radii, m.");
}

}    // namespace granwave::bindings
