#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "services/contract/sequence.hpp"

namespace tonus::store {

using tonus::SequenceRange;

/// Which sample numbers of a stream are there, as the fewest ranges that say so. Order of arrival, overlap
/// and repetition do not matter: the same numbers added in any way give the same Coverage. Adding at the end
/// is O(1), elsewhere O(ranges).
class Coverage {
 public:
  Coverage() = default;

  /// Adds numbers and returns how many of them were not there before. An empty range adds nothing.
  std::uint64_t add(SequenceRange range);

  /// How many numbers of `range` are there.
  [[nodiscard]] std::uint64_t count_in(SequenceRange range) const;

  /// True where every number of `range` is there; an empty range always is.
  [[nodiscard]] bool covers(SequenceRange range) const { return count_in(range) == range.count(); }

  /// The smallest number from `from` on that is not there.
  [[nodiscard]] std::uint64_t first_missing(std::uint64_t from) const;

  /// What of `within` is not there, ascending, at most `limit` ranges.
  [[nodiscard]] std::vector<SequenceRange> missing(
      SequenceRange within, std::size_t limit = std::numeric_limits<std::size_t>::max()) const;

  /// The numbers that are in both. O(ranges of both).
  [[nodiscard]] Coverage common(const Coverage& other) const;

  /// One more than the largest number; 0 where there is none.
  [[nodiscard]] std::uint64_t end() const { return ranges_.empty() ? 0 : ranges_.back().end; }

  /// Ascending, not empty, not touching each other.
  [[nodiscard]] const std::vector<SequenceRange>& ranges() const { return ranges_; }

  bool operator==(const Coverage&) const = default;

 private:
  std::vector<SequenceRange> ranges_;
};

}  // namespace tonus::store
