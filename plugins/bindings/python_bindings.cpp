// SPDX-License-Identifier: GPL-2.0-only
/* Python bindings of the contact laws: functions, shapes, the table of laws, and the law of one contact; SI units. */

#include "../laws/cylinders.h"
#include "../laws/load_shape.h"
#include "bound_contact.h"
#include "bound_laws.h"
#include "bound_mesh.h"
#include "bound_shapes.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <vector>

namespace py = pybind11;
using namespace granwave;

PYBIND11_MODULE(_contact_laws, module)
{
  const py::arg x("x");
  module.doc() =
      "Force-overlap laws of a contact: the functions that the LAMMPS pair style uses, for numpy arrays in SI units.";
  module.attr("LAMMPS_RELEASE") = GRANWAVE_LAMMPS_RELEASE;
  module.def("power", py::vectorize(power), x, py::arg("y"), "x^y as the laws compute it, for positive x.");
  module.def("elliptic_radius", py::vectorize(elliptic_radius), py::arg("first"), py::arg("second"),
             "Radius of the sphere that is as stiff on a plane as a contact with these two relative curvatures (1/m), m.");
  module.def(
      "load_at",
      [](const std::string &shape, const std::vector<double> &numbers, const py::array_t<double> &time) -> py::object {
        const auto load = LoadShape::named(shape, numbers);
        return py::vectorize([&load](double t) { return load.value(t); })(time);
      },
      py::arg("shape"), py::arg("numbers"), py::arg("time"),
      "Force or displacement at times (s), from the arguments of fix gran/load.");
  module.def("logarithm", py::vectorize(logarithm), x, "ln(x) as the laws compute it, for positive x.");
  module.def("exponential", py::vectorize(exponential), x, "exp(x) as the laws compute it.");
  bindings::bind_shapes(module);
  bindings::bind_mesh(module);
  bindings::bind_laws(module);
  bindings::bind_contact(module);
}
