#pragma once

#include <compare>
#include <cstdint>

namespace tonus {

/// How a range of samples stands in the archive.
struct Certificate {
  std::uint64_t expected = 0;
  std::uint64_t received = 0;    ///< Different samples of the range that are there.
  std::uint64_t resent = 0;      ///< Of those, the ones that came first in a resent block.
  std::uint64_t duplicated = 0;  ///< Samples that came when they were there already.
  std::uint64_t missing = 0;
  auto operator<=>(const Certificate&) const = default;

  Certificate& operator+=(const Certificate& other) {
    expected += other.expected;
    received += other.received;
    resent += other.resent;
    duplicated += other.duplicated;
    missing += other.missing;
    return *this;
  }
};

}  // namespace tonus
