#pragma once

#include <atomic>
#include <cstdint>

namespace tonus::control {

/// What the loop and its watchdog, another process, tell each other: a page of shared memory, all zero at
/// first. Each member is a sign by itself and orders nothing else.
struct Pulse {
  std::atomic<std::uint64_t> cycles;       ///< Of the loop, after their torque was written.
  std::atomic<std::uint32_t> is_powered;   ///< Not 0: the watchdog watches. By the agent.
  std::atomic<std::uint32_t> has_tripped;  ///< Not 0: the watchdog has dropped the torque. By the watchdog.
  std::atomic<std::uint64_t> looks;        ///< How often the watchdog has looked. By the watchdog.
  std::atomic<std::uint32_t> is_ending;    ///< Not 0: the agent ends in order. By the agent.
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free &&
              std::atomic<std::uint32_t>::is_always_lock_free);

}  // namespace tonus::control
