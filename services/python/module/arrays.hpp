#pragma once

#include <memory>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <string>
#include <vector>

#include "services/python/module/signals.hpp"

namespace tonus::python {

/// Columns as NumPy arrays that look into one Signals, which lives as long as any of them; nothing is copied,
/// and nothing may be written. Keys: time, position, force, commanded, phase, is_missing; pairs are rows x
/// axes.
[[nodiscard]] pybind11::dict arrays_of(std::shared_ptr<const Signals> signals);

}  // namespace tonus::python
