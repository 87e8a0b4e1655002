#pragma once

#include <pybind11/pybind11.h>

namespace tonus::python {

/// Dataset, Recording, simulate() and identify_arrays() of the module.
void bind_recordings(pybind11::module_& module);

/// Archive and Session of the module.
void bind_archives(pybind11::module_& module);

}  // namespace tonus::python
