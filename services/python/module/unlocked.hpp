#pragma once

#include <pybind11/pybind11.h>
#include <utility>

#include "services/python/module/errors.hpp"

namespace tonus::python {

/// Runs `work`, which gives a Result, without the interpreter's lock; then its value, or its error raised.
template <typename Work>
auto unlocked(const Work& work) {
  auto result = [&] {
    const pybind11::gil_scoped_release release;
    return work();
  }();
  return value_of(std::move(result));
}

}  // namespace tonus::python
