// SPDX-License-Identifier: GPL-2.0-only
/* Contacts along lines, and pairs of cylinders, as Python has them. */

#ifndef GRANWAVE_BINDINGS_BOUND_SHAPES_H
#define GRANWAVE_BINDINGS_BOUND_SHAPES_H

#include <pybind11/pybind11.h>

namespace granwave::bindings {

/* Make the classes LineContact and CylinderPair of Python. */
void bind_shapes(pybind11::module_ &module);

}    // namespace granwave::bindings

#endif
