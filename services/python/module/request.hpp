#pragma once

#include <pybind11/pybind11.h>

#include "analysis_service/offline/request.hpp"

namespace tonus::python {

/// What identify() was asked for: method, model, window (s), cutoff (Hz), natural_frequency (Hz, None: from
/// the data), damping_ratio. Raises TypeError for another key.
[[nodiscard]] identification::Request request_of(const pybind11::kwargs& settings);

}  // namespace tonus::python
