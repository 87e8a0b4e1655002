#pragma once

#include <compare>
#include <cstdint>

#include "services/core/id.hpp"

/// How samples are named in all services.
namespace tonus {

/// Samples of one rig from one start of its agent, numbered from 0 without gaps.
struct StreamKey {
  Id rig{};
  std::uint64_t epoch = 0;  ///< Start of the agent, ns of UTC.
  auto operator<=>(const StreamKey&) const = default;
};

/// Sample numbers first .. end - 1. The contract's messages name the last number instead: see
/// from_first_to_last().
struct SequenceRange {
  std::uint64_t first = 0;
  std::uint64_t end = 0;

  /// Both numbers belong to the range; `last` is not below `first` and below the largest number.
  [[nodiscard]] static constexpr SequenceRange from_first_to_last(std::uint64_t first, std::uint64_t last) {
    return {first, last + 1};
  }

  [[nodiscard]] constexpr bool is_empty() const { return end <= first; }
  [[nodiscard]] constexpr std::uint64_t count() const { return end - first; }
  /// Last number of a range that is not empty.
  [[nodiscard]] constexpr std::uint64_t last() const { return end - 1; }
  [[nodiscard]] constexpr bool contains(std::uint64_t number) const {
    return number >= first && number < end;
  }
  bool operator==(const SequenceRange&) const = default;
};

}  // namespace tonus
