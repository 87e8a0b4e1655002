#include "tests/fault/rig/stall.hpp"

#include <algorithm>
#include <csignal>
#include <exception>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "tests/fault/rig/live_system.hpp"
#include "tests/support/bus/private_network.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kPatience{120};
constexpr double kTrialTime = 3.5;  // s, at least.

Error stuck(const LiveSystem& system, const std::string& what) {
  return {ErrorCode::kTimeout, what + "\n" + system.everything_printed()};
}

Stretch between(const v1::RigTiming& from, const v1::RigTiming& to) {
  return {to.cycles() - from.cycles(), to.overruns() - from.overruns(),
          to.missed_periods() - from.missed_periods()};
}

/// Hears the rig's timing until `cycles` after `from`.
bool listen_for_cycles(LiveSystem& system, const v1::RigTiming& from, std::uint64_t cycles) {
  return system.listen_until(
      [&] { return system.timing() && system.timing()->cycles() >= from.cycles() + cycles; }, kPatience);
}

Result<void> stop_bus() {
  if (auto made = test::run_program({"nft", "add", "table", "inet", "stall"}); !made) return made;
  if (auto made = test::run_program(
          {"nft", "add", "chain", "inet", "stall", "in", "{ type filter hook input priority 0 ; }"});
      !made) {
    return made;
  }
  return test::run_program({"nft", "add", "rule", "inet", "stall", "in", "meta", "l4proto", "udp", "drop"});
}

Result<void> start_bus() { return test::run_program({"nft", "delete", "table", "inet", "stall"}); }

void count_trials(const store::Session& session, StallReport& report) {
  std::set<std::uint32_t> counted;
  for (const auto& trial : session.trials) {
    if (trial.outcome && trial.outcome->value.end() == v1::TRIAL_FAULTED) ++report.faulted_trials;
    if (trial.verdict && trial.verdict->value.is_valid())
      counted.insert(trial.verdict->value.planned_index());
  }
  report.counted_trials = static_cast<unsigned>(counted.size());
  report.planned_trials = session.record.planned_trials;
}

Result<StallReport> run(Stall stall, unsigned seconds) {
  // A trial takes about 4 s, so that none outlasts a scheduler that stands still.
  LiveSystem system(LiveSystem::Unattended::kYes, "fastdds", 5.0);
  const int directions = 4 + static_cast<int>(seconds / kTrialTime);
  system.start_session(directions);
  if (!system.wait_for_mid_trial(40, kPatience) || !system.timing())
    return stuck(system, "the rig does not run a trial");
  const std::uint64_t wanted = static_cast<std::uint64_t>(seconds / system.timing()->period_s());

  StallReport report;
  const v1::RigTiming first = *system.timing();
  if (!listen_for_cycles(system, first, wanted)) return stuck(system, "the loop does not go on");
  report.before = between(first, *system.timing());
  if (!system.wait_for_mid_trial(40, kPatience)) return stuck(system, "the rig does not run another trial");

  const v1::RigTiming second = *system.timing();
  if (stall == Stall::kServices) {
    system.signal_others(SIGSTOP);
    const bool went_on = listen_for_cycles(system, second, wanted);
    system.signal_others(SIGCONT);
    if (!went_on) return stuck(system, "the loop does not go on while the services stand still");
  } else {
    // Nothing is heard meanwhile but the disk: a sample takes at least 40 bytes of the spool.
    const std::uint64_t spooled = system.spooled_bytes();
    if (auto stopped = stop_bus(); !stopped) return stopped.error();
    const bool went_on = system.listen_until(
        [&] { return system.spooled_bytes() >= spooled + std::uint64_t{40} * 200 * seconds; }, kPatience);
    if (auto started = start_bus(); !started) return started.error();
    if (!went_on) return stuck(system, "the rig does not spool while the bus stands still");
    if (!listen_for_cycles(system, second, wanted)) return stuck(system, "the rig is not heard again");
  }
  report.stalled = between(second, *system.timing());

  if (const int code = system.finish_session(std::chrono::seconds(directions * 12) + kPatience); code != 0)
    return stuck(system, fmt::format("the session ended with {}", code));
  report.dropped_samples = system.state()->dropped_samples();
  report.samples = system.state()->next_sequence();
  count_trials(system.archived(), report);
  // The samples after the last trial are on their way while the archive is read.
  const auto is_whole = [&] { return (report.missing = missing_samples(system.store_file())).empty(); };
  (void)system.listen_until(is_whole, std::chrono::seconds(20));
  return report;
}

}  // namespace

Result<StallReport> run_stalled_session(Stall stall, unsigned seconds) {
  try {
    return run(stall, seconds);
  } catch (const std::exception& error) {
    return Error{ErrorCode::kInternal, error.what()};
  }
}

std::string text_of(const StallReport& r) {
  const auto line = [](const char* what, const Stretch& s) {
    return fmt::format("{}: {} cycles, {} overruns, {} periods missed\n", what, s.cycles, s.overruns,
                       s.missed_periods);
  };
  return line("services running", r.before) + line("stalled", r.stalled) +
         fmt::format("samples taken {}, dropped {}; archive: {}\n", r.samples, r.dropped_samples,
                     r.missing.empty() ? "every sample" : r.missing) +
         fmt::format("trials counted {} of {}, ended by a fault {}\n", r.counted_trials, r.planned_trials,
                     r.faulted_trials);
}

}  // namespace tonus::testing
