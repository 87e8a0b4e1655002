#include "services/store/coverage.hpp"

#include <algorithm>

namespace tonus::store {
namespace {

/// First range that ends after `number`, that is, contains it or lies above it.
auto first_ending_after(const std::vector<SequenceRange>& ranges, std::uint64_t number) {
  return std::upper_bound(ranges.begin(), ranges.end(), number,
                          [](std::uint64_t value, const SequenceRange& range) { return value < range.end; });
}

}  // namespace

std::uint64_t Coverage::add(SequenceRange range) {
  if (range.end <= range.first) return 0;
  if (!ranges_.empty() && ranges_.back().end == range.first) {
    ranges_.back().end = range.end;
    return range.count();
  }
  const std::uint64_t fresh = range.count() - count_in(range);
  // Ranges that overlap or touch the new one become one with it.
  const auto begin =
      std::lower_bound(ranges_.begin(), ranges_.end(), range.first,
                       [](const SequenceRange& r, std::uint64_t value) { return r.end < value; });
  const auto end =
      std::upper_bound(begin, ranges_.end(), range.end,
                       [](std::uint64_t value, const SequenceRange& r) { return value < r.first; });
  if (begin == end) {
    ranges_.insert(begin, range);
    return fresh;
  }
  begin->first = std::min(begin->first, range.first);
  begin->end = std::max(std::prev(end)->end, range.end);
  ranges_.erase(std::next(begin), end);
  return fresh;
}

std::uint64_t Coverage::count_in(SequenceRange range) const {
  std::uint64_t count = 0;
  for (auto r = first_ending_after(ranges_, range.first); r != ranges_.end() && r->first < range.end; ++r) {
    count += std::min(r->end, range.end) - std::max(r->first, range.first);
  }
  return count;
}

std::uint64_t Coverage::first_missing(std::uint64_t from) const {
  const auto range = first_ending_after(ranges_, from);
  return range != ranges_.end() && range->first <= from ? range->end : from;
}

std::vector<SequenceRange> Coverage::missing(SequenceRange within, std::size_t limit) const {
  std::vector<SequenceRange> gaps;
  std::uint64_t next = within.first;
  auto range = first_ending_after(ranges_, within.first);
  while (next < within.end && gaps.size() < limit) {
    const bool has_range = range != ranges_.end() && range->first < within.end;
    const std::uint64_t gap_end = has_range ? range->first : within.end;
    if (next < gap_end) gaps.push_back({next, gap_end});
    if (!has_range) break;
    next = range->end;
    ++range;
  }
  return gaps;
}

Coverage Coverage::common(const Coverage& other) const {
  Coverage both;
  auto a = ranges_.begin();
  auto b = other.ranges_.begin();
  while (a != ranges_.end() && b != other.ranges_.end()) {
    both.add({std::max(a->first, b->first), std::min(a->end, b->end)});
    a->end < b->end ? ++a : ++b;
  }
  return both;
}

}  // namespace tonus::store
