// SPDX-License-Identifier: GPL-2.0-only
#include "bound_mesh.h"

#include "../kernels/triangle_mesh.h"
#include "arguments.h"

#include <pybind11/numpy.h>

#include <algorithm>
#include <limits>

namespace py = pybind11;

namespace granwave::bindings {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

Array corners_of(const std::vector<double> &numbers)
{
  Array corners({static_cast<py::ssize_t>(numbers.size() / 9), py::ssize_t(3), py::ssize_t(3)});
  std::copy(numbers.begin(), numbers.end(), corners.mutable_data());
  return corners;
}

/* Distances of positions (n, 3) from a patch, infinite where the nearest point belongs to another patch, and nearest points.
   */
py::tuple nearest_points(const TriangleMesh &mesh, const Array &positions, int patch)
{
  require(positions.ndim() == 2 && positions.shape(1) == 3, "positions must be of the shape (n, 3)");
  require(patch >= 1 && patch <= mesh.n_patches(), "patches are numbered from 1");
  const py::ssize_t n = positions.shape(0);
  Array distances(n), points({n, py::ssize_t(3)});
  for (py::ssize_t k = 0; k < n; k++) {
    const double *const x = positions.data() + 3 * k;
    const SurfacePoint nearest = mesh.nearest(x, patch - 1);
    const bool owns = mesh.owns(x, patch - 1, nearest);
    distances.mutable_at(k) = owns ? nearest.distance : std::numeric_limits<double>::infinity();
    std::copy_n(nearest.point, 3, points.mutable_data() + 3 * k);
  }
  return py::make_tuple(distances, points);
}

}    // namespace

void bind_mesh(py::module_ &module)
{
  module.def(
      "read_stl", [](const py::bytes &content) { return corners_of(read_stl(content)); }, py::arg("content"),
      "Corners of the triangles of an STL file, text or binary: (n, 3, 3), in its unit.");
  py::class_<TriangleMesh>(module, "TriangleMesh",
                           "Surface of triangles with corners (n, 3, 3), divided into smooth patches, which are numbered "
                           "from 1: neighbouring triangles of a patch differ in direction by at most this angle, degrees.")
      .def(py::init([](const Array &corners, double angle) {
             require(corners.ndim() == 3 && corners.shape(1) == 3 && corners.shape(2) == 3,
                     "corners must be of the shape (n, 3, 3)");
             return TriangleMesh(std::vector<double>(corners.data(), corners.data() + corners.size()), angle);
           }),
           py::arg("corners"), py::arg("angle"))
      .def_property_readonly("n_patches", &TriangleMesh::n_patches, "number of patches")
      .def_property_readonly("n_triangles", &TriangleMesh::n_triangles, "number of triangles with an area")
      .def("nearest", &nearest_points, py::arg("positions"), py::arg("patch"),
           "Distances (n,) of positions (n, 3) from a patch, infinite where its nearest point belongs to another patch, and "
           "nearest points (n, 3).");
}

}    // namespace granwave::bindings
