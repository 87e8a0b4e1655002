#pragma once

#include <chrono>
#include <thread>

namespace tonus::test {

/// True as soon as the condition holds; false if it does not within `limit`, which is far above what is
/// expected.
template <typename Condition>
[[nodiscard]] bool eventually(const Condition& condition,
                              std::chrono::steady_clock::duration limit = std::chrono::seconds{20}) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  return true;
}

}  // namespace tonus::test
