#pragma once

#include <vector>

#include "services/bus/typed.hpp"

namespace tonus::runtime {

/// Everything that has arrived on a reader and decodes, in order.
template <typename T>
[[nodiscard]] std::vector<bus::Received<T>> drain(bus::TypedReader<T>& reader) {
  constexpr std::size_t kBatch = 256;
  std::vector<bus::Received<T>> received;
  while (reader.take(received, kBatch) == kBatch) {
  }
  return received;
}

}  // namespace tonus::runtime
