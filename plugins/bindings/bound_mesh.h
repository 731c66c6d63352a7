// SPDX-License-Identifier: GPL-2.0-only
/* Surfaces of triangles, as Python has them. */

#ifndef GRANWAVE_BINDINGS_BOUND_MESH_H
#define GRANWAVE_BINDINGS_BOUND_MESH_H

#include <pybind11/pybind11.h>

namespace granwave::bindings {

/* Make the class TriangleMesh and the function read_stl of Python. */
void bind_mesh(pybind11::module_ &module);

}    // namespace granwave::bindings

#endif
