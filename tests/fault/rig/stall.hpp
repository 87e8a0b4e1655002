#pragma once

#include <cstdint>
#include <string>

#include "services/core/result.hpp"

namespace tonus::testing {

/// What stands still.
enum class Stall {
  kServices,  ///< SIGSTOP of every program but the rig agent.
  kBus,       ///< Every packet is dropped; only in a private network.
};

/// What the loop did over a stretch of its cycles.
struct Stretch {
  std::uint64_t cycles = 0;
  std::uint64_t overruns = 0;
  std::uint64_t missed_periods = 0;
};

struct StallReport {
  Stretch before;  ///< As long as the stall, all services running.
  Stretch stalled;
  std::uint64_t dropped_samples = 0;  ///< Between the loop and its publisher, since the start.
  std::uint64_t samples = 0;          ///< Taken in all.
  std::string missing;                ///< In the archive at the end; empty: nothing.
  unsigned faulted_trials = 0;        ///< Ended by a fault of the rig.
  unsigned counted_trials = 0;
  unsigned planned_trials = 0;
};

/// Runs a session in real time, stalls in the middle of a trial for `seconds` of the loop, lets go, and waits
/// for the session's end. An error where something did not come to its end at all.
[[nodiscard]] Result<StallReport> run_stalled_session(Stall stall, unsigned seconds);

[[nodiscard]] std::string text_of(const StallReport& report);

}  // namespace tonus::testing
