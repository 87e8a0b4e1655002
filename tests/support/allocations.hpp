#pragma once

#include <cstddef>

/// A program that links tonus_support_allocations has its malloc and its kin replaced by ones that take notes
/// and pass on to the C library's. Eigen takes its memory from malloc, and so does operator new.
namespace tonus::testing {

/// Heap allocations of the whole program so far.
[[nodiscard]] std::size_t allocations();

/// Octets of the largest one since forget_allocations().
[[nodiscard]] std::size_t largest_allocation();
void forget_allocations();

/// False in a sanitizer's build, which brings its own malloc: nothing is noted there.
[[nodiscard]] bool counts_allocations();

}  // namespace tonus::testing
