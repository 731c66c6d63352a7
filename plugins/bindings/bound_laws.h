// SPDX-License-Identifier: GPL-2.0-only
/* The table of laws and their parameters for Python. */

#ifndef GRANWAVE_BINDINGS_BOUND_LAWS_H
#define GRANWAVE_BINDINGS_BOUND_LAWS_H

#include <pybind11/pybind11.h>

namespace granwave::bindings {

/* Define the Python classes LawParameter and LawEntry, and the tables LAWS, PARAMETERS and FE_RANGE. */
void bind_laws(pybind11::module_ &module);

}    // namespace granwave::bindings

#endif
