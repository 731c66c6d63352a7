// SPDX-License-Identifier: GPL-2.0-only
/* Triangulated surfaces for Python. */

#ifndef GRANWAVE_BINDINGS_BOUND_MESH_H
#define GRANWAVE_BINDINGS_BOUND_MESH_H

#include <pybind11/pybind11.h>

namespace granwave::bindings {

/* Define the Python class TriangleMesh and the function read_stl. */
void bind_mesh(pybind11::module_ &module);

}    // namespace granwave::bindings

#endif
