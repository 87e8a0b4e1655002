#pragma once

#include <cstddef>

namespace tonus::impedance::test {

/// Heap allocations of the whole program so far, by operator new, by Eigen or by malloc itself.
[[nodiscard]] std::size_t allocations();

/// False in a sanitizer's build, which brings its own malloc: nothing is counted there.
[[nodiscard]] bool counts_allocations();

}  // namespace tonus::impedance::test
