// SPDX-License-Identifier: GPL-2.0-only
/* Line contacts, and pairs of cylinders, for Python. */

#ifndef GRANWAVE_BINDINGS_BOUND_SHAPES_H
#define GRANWAVE_BINDINGS_BOUND_SHAPES_H

#include <pybind11/pybind11.h>

namespace granwave::bindings {

/* Define the Python classes LineContact and CylinderPair. */
void bind_shapes(pybind11::module_ &module);

}    // namespace granwave::bindings

#endif
