#include "services/runtime/refused_packets_log.hpp"

#include <mutex>
#include <spdlog/spdlog.h>

#include "services/bus/refused_packets.hpp"

namespace tonus::runtime {
namespace {

constexpr std::chrono::seconds kQuiet{10};

/// Of the process, as what it counts.
struct Logged {
  std::mutex mutex;
  std::uint64_t packets = 0;
  Clock::TimePoint quiet_until;
};

Logged& logged() {
  static Logged state;
  return state;
}

}  // namespace

void log_refused_packets(const Clock& clock) {
  const std::uint64_t packets = bus::refused_packets();
  Logged& state = logged();
  const std::lock_guard lock(state.mutex);
  if (packets == state.packets || clock.now() < state.quiet_until) return;
  spdlog::warn(
      "{} malformed packets were dropped; a program of another kind, or one that means harm, sends to this "
      "program's ports",
      packets - state.packets);
  state.packets = packets;
  state.quiet_until = clock.now() + kQuiet;
}

}  // namespace tonus::runtime
