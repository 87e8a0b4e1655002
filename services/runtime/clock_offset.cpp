#include "services/runtime/clock_offset.hpp"

#include <algorithm>

namespace tonus::runtime {
namespace {

std::int64_t bound(const RoundTrip& trip, std::int64_t now) {
  const auto age = static_cast<double>(std::max<std::int64_t>(0, now - trip.returned));
  return (trip.duration() + 1) / 2 + static_cast<std::int64_t>(ClockOffset::kDrift * age);
}

}  // namespace

bool ClockOffset::add(const RoundTrip& trip) {
  if (trip.duration() < 0 || trip.answered < trip.received) return false;
  trips_.push_back(trip);
  if (trips_.size() > kWindow) trips_.pop_front();
  return true;
}

std::optional<ClockDifference> ClockOffset::at(std::int64_t now) const {
  if (trips_.empty()) return std::nullopt;
  const auto best = std::min_element(trips_.begin(), trips_.end(), [now](const auto& a, const auto& b) {
    return bound(a, now) < bound(b, now);
  });
  const std::int64_t there = best->received - best->asked;
  const std::int64_t back = best->answered - best->returned;
  // Halved separately: each may be as large as a clock's reading.
  return ClockDifference{there / 2 + back / 2 + (there % 2 + back % 2) / 2, bound(*best, now), trips_.size()};
}

}  // namespace tonus::runtime
