#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::testing {

/// One thing that befalls a running session.
struct Step {
  enum class Act {
    kKill,     ///< SIGKILL of a program; the supervisor starts it anew.
    kPause,    ///< SIGSTOP, then SIGCONT after `lasts`.
    kRestart,  ///< All programs end in order and start anew.
    kStop,     ///< An operator's `tonus stop`.
    // Of simulated systems alone:
    kTear,          ///< The program dies in its write number `count` from now on, to disk or bus.
    kCut,           ///< The program is cut off from the network for `lasts`.
    kFillDisk,      ///< The program's disk is full for `lasts`.
    kStepClock,     ///< The machine's UTC steps by `lasts`.
    kPauseSession,  ///< An operator's pause; a resume follows.
    kAbortSession,  ///< An operator's abort.
  };
  Act act = Act::kKill;
  std::string program;  ///< Of kKill, kPause, kTear, kCut and kFillDisk: "rig-agent", "scheduler",
                        ///< "identification", "archive".
  double after = 0.0;   ///< s from the step before, or from the first trial.
  double lasts = 0.0;   ///< s, of kPause, kCut, kFillDisk and kStepClock.
  unsigned count = 0;   ///< Of kTear.
};

using Scenario = std::vector<Step>;

/// "kill scheduler after 1.25; pause archive after 0.50 for 3.00; restart after 2.00; stop after 0.30".
[[nodiscard]] std::string to_text(const Scenario& scenario);
/// The same read back. kInvalidArgument names the step that is not one.
[[nodiscard]] Result<Scenario> parse_scenario(std::string_view text);

/// `steps` steps drawn from the seed; the same seed draws the same. Only what can befall real programs.
[[nodiscard]] Scenario draw_scenario(std::uint64_t seed, unsigned steps);

/// Likewise, of everything that there is.
[[nodiscard]] Scenario draw_simulated_scenario(std::uint64_t seed, unsigned steps);

/// Runs a session on a system of its own, lets the steps happen, and does what an operator does: clears a rig
/// that is held, then resumes. Empty where every invariant held, else those that did not, one a line:
///
/// - no trial begins between an end or restart of the agent or the scheduler, a stop or a hold, and an
///   operator's resume;
/// - the session ends with every planned trial counted once;
/// - the archive holds every sample of every stream, and `tonus verify` finds all well.
///
/// An error where the scenario could not be run.
[[nodiscard]] Result<std::string> run_scenario(const Scenario& scenario, const std::string& dds);

/// A short scenario, made by leaving out steps, halves first, that still breaks what `breaks` says; at most
/// `tries` calls. What follows a step that is left out happens when it did.
[[nodiscard]] Scenario shrink(Scenario scenario, const std::function<bool(const Scenario&)>& breaks,
                              unsigned tries);

}  // namespace tonus::testing
