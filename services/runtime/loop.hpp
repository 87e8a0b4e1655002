#pragma once

#include <functional>

#include "services/bus/notifier.hpp"
#include "services/core/clock.hpp"
#include "services/core/lifetime.hpp"
#include "services/core/result.hpp"

namespace tonus::runtime {

/// A service is one thread: `step` handles everything that is there now and returns when it must be called
/// again even if nothing arrives. Runs until the stop signal; `step` runs at least once.
inline void run_loop(bus::Notifier& notifier, const StopSignal& stop,
                     const std::function<Clock::TimePoint()>& step) {
  while (true) {
    const Clock::TimePoint due = step();
    if (stop.is_requested()) return;
    (void)notifier.wait_until(due);
    if (stop.is_requested()) return;
  }
}

/// As above; a step's error ends the loop and is returned.
[[nodiscard]] inline Result<void> run_loop_until_error(
    bus::Notifier& notifier, const StopSignal& stop, const std::function<Result<Clock::TimePoint>()>& step) {
  while (true) {
    TONUS_TRY_ASSIGN(const Clock::TimePoint due, step());
    if (stop.is_requested()) return {};
    (void)notifier.wait_until(due);
    if (stop.is_requested()) return {};
  }
}

}  // namespace tonus::runtime
