#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace tonus::runtime {

/// One question and its answer. Asked and returned are by the asker's clock, received and answered by the
/// answerer's; ns.
struct RoundTrip {
  std::int64_t asked = 0;
  std::int64_t received = 0;
  std::int64_t answered = 0;
  std::int64_t returned = 0;

  /// Time on the way, both ways together: (returned - asked) - (answered - received).
  [[nodiscard]] std::int64_t duration() const { return (returned - asked) - (answered - received); }
};

/// How far another clock is ahead, ns: the true offset is within `uncertainty` of `offset`.
struct ClockDifference {
  std::int64_t offset = 0;
  std::int64_t uncertainty = 0;
  std::uint64_t round_trips = 0;  ///< That it was chosen from.
};

/// The difference of two clocks from round trips, by the shortest one:
///
///     offset = ((received - asked) + (answered - returned)) / 2,   |error| <= duration / 2,
///
/// whatever the way there and the way back each took (RFC 5905, section 8). As two clocks drift apart, a
/// round trip's bound grows with its age by `kDrift` of it; the one with the smallest bound now is taken. The
/// last `kWindow` round trips are kept. Those that cannot be (a way of negative length) are left out.
class ClockOffset {
 public:
  static constexpr std::size_t kWindow = 64;
  static constexpr double kDrift = 50e-6;  ///< What two crystals of 25 ppm each may differ by.

  /// False where it was left out.
  bool add(const RoundTrip& trip);

  /// None before the first round trip. `now` is by the asker's clock.
  [[nodiscard]] std::optional<ClockDifference> at(std::int64_t now) const;

 private:
  std::deque<RoundTrip> trips_;
};

}  // namespace tonus::runtime
