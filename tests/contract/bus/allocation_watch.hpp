#pragma once

#include <cstddef>

/// Replaces this program's operator new by one that remembers the largest single request.
namespace tonus::bus::test {

void forget_allocations();
[[nodiscard]] std::size_t largest_allocation();

}  // namespace tonus::bus::test
