#pragma once

#include <algorithm>
#include <chrono>

/// What both vendors' discovery has to agree on.
namespace tonus::bus {

/// Without multicast a participant looks for its peers at well-known ports: so many of each host can find
/// each other. A process may take two places (cyclonedds/). RTPS ports of domain 232 leave room for 62.
inline constexpr int kMaximumParticipantsPerHost = 40;

/// How often a participant announces itself: a missed announcement costs that long, and a lease needs
/// several.
[[nodiscard]] constexpr std::chrono::milliseconds announcement_period(std::chrono::milliseconds lease) {
  return std::min(lease / 3, std::chrono::milliseconds{500});
}

}  // namespace tonus::bus
