#pragma once

#include <utility>

#include "services/core/result.hpp"

namespace tonus::python {

/// Raises the Python exception of the error's kind (tonus/errors.py) with its message. The caller holds the
/// interpreter's lock.
[[noreturn]] void raise(const Error& error);

/// The value, or its error as a Python exception. The caller holds the interpreter's lock.
template <typename T>
[[nodiscard]] T value_of(Result<T> result) {
  if (!result) raise(result.error());
  return std::move(result).value();
}

}  // namespace tonus::python
