#pragma once

#include <stdexcept>
#include <utility>

#include "services/core/result.hpp"

namespace tonus::testing {

/// The value of a step without which a test cannot go on; throws std::runtime_error with the error's message.
template <typename T>
T needed(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

}  // namespace tonus::testing
