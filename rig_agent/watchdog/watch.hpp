#pragma once

#include <chrono>
#include <functional>

#include "rig_agent/control/pulse.hpp"

namespace tonus::watchdog {

struct WatchOptions {
  std::chrono::nanoseconds limit{};      ///< Longest time without a cycle.
  std::function<bool()> disable;         ///< Drops the torque; true: the device has confirmed it.
  std::function<bool()> is_agent_there;  ///< False once the agent's process has ended.
  std::function<void(std::chrono::nanoseconds)> rest;  ///< Sleeps.
  std::function<std::chrono::nanoseconds()> now;       ///< Monotonic.
};

/// How a watch ended.
enum class WatchEnd {
  kInOrder,      ///< The agent said that it ends.
  kAgentIsGone,  ///< It did not; the torque was dropped, and the device has confirmed it.
};

/// Looks at the loop's pulse five times within the limit, from its first cycle on. When no cycle came for
/// longer than the limit while the rig is under power, drops the torque, notes it in the pulse, and goes on
/// dropping it in every look for as long as the agent's process is there: one that wakes up again must not
/// undo it. Knows nothing of the bus, the trial or the hand.
[[nodiscard]] WatchEnd watch(control::Pulse& pulse, const WatchOptions& options);

}  // namespace tonus::watchdog
