#include "rig_agent/watchdog/watch.hpp"

namespace tonus::watchdog {

WatchEnd watch(control::Pulse& pulse, const WatchOptions& options) {
  constexpr auto kOrder = std::memory_order_relaxed;
  std::uint64_t last = pulse.cycles.load(kOrder);
  auto seen_at = options.now();
  bool has_tripped = false;
  bool is_confirmed = false;
  while (true) {
    pulse.looks.fetch_add(1, kOrder);
    if (pulse.is_ending.load(kOrder) != 0 && !has_tripped) return WatchEnd::kInOrder;
    const bool is_there = options.is_agent_there();
    const std::uint64_t cycles = pulse.cycles.load(kOrder);
    const bool is_powered = pulse.is_powered.load(kOrder) != 0;
    if (cycles != last || cycles == 0 || !is_powered) {
      last = cycles;
      seen_at = options.now();
    }
    if (is_powered && (!is_there || options.now() - seen_at > options.limit)) has_tripped = true;
    if (has_tripped) {
      pulse.has_tripped.store(1, kOrder);
      is_confirmed = options.disable();
    }
    if (!is_there && (!has_tripped || is_confirmed)) return WatchEnd::kAgentIsGone;
    options.rest(options.limit / 5);
  }
}

}  // namespace tonus::watchdog
