#include "tests/fault/rig/pause.hpp"

#include <algorithm>
#include <csignal>
#include <exception>
#include <random>
#include <spdlog/fmt/fmt.h>

#include "tests/fault/rig/live_system.hpp"

namespace tonus::testing {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience{120};
constexpr double kLimit_s = 10.0;
constexpr int kDirections = 36;
constexpr const char* kPrograms[] = {"tonus-rig-agent", "tonus-archive", "tonus-identification",
                                     "tonus-scheduler"};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A set of programs that is not empty.
class Chosen {
 public:
  Chosen(const LiveSystem& system, std::mt19937_64& random) {
    constexpr unsigned kSets = 1U << std::size(kPrograms);
    const auto set = std::uniform_int_distribution<unsigned>(1, kSets - 1)(random);
    for (std::size_t i = 0; i < std::size(kPrograms); ++i) {
      if ((set >> i & 1U) == 0) continue;
      names_ += (names_.empty() ? "" : " ") + std::string(kPrograms[i]);
      processes_.push_back(system.service(kPrograms[i]));
    }
  }
  void signal(int number) const {
    for (const pid_t process : processes_) {
      if (process > 0) kill(process, number);
    }
  }
  [[nodiscard]] const std::string& names() const { return names_; }

 private:
  std::string names_;
  std::vector<pid_t> processes_;
};

std::uint32_t attempts(const LiveSystem& system) {
  return system.session() ? system.session()->attempts() : 0;
}

/// Waits for the next trial to be commanded, or for the session's end.
bool next_trial(LiveSystem& system, std::uint32_t before) {
  return system.listen_until(
      [&] {
        return attempts(system) != before ||
               (system.session() && system.session()->phase() == v1::SESSION_COMPLETED);
      },
      kPatience);
}

/// A session that has more than a few trials to go.
Result<void> keep_a_session(LiveSystem& system, bool& has_session) {
  constexpr std::uint32_t kEnough = 4;
  const auto& state = system.session();
  if (has_session && state && state->counted() + kEnough < state->planned()) return {};
  if (has_session && system.finish_session(kPatience) != 0)
    return fail(ErrorCode::kTimeout, "a session did not complete\n" + system.everything_printed());
  system.start_session(kDirections);
  has_session = true;
  if (system.wait_for_mid_trial(40, kPatience)) return {};
  return fail(ErrorCode::kTimeout, "a session did not start\n" + system.everything_printed());
}

Result<Pause> pause_once(LiveSystem& system, const PauseCampaign& campaign, std::mt19937_64& random) {
  const Chosen chosen(system, random);
  Pause pause;
  pause.programs = chosen.names();
  pause.seconds = std::uniform_real_distribution<double>(campaign.shortest_s, campaign.longest_s)(random);
  const auto stopped = Clock::now();
  chosen.signal(SIGSTOP);
  (void)system.listen_until([&] { return seconds_since(stopped) >= pause.seconds; }, kPatience);
  const std::uint32_t before = attempts(system);
  chosen.signal(SIGCONT);
  const auto resumed = Clock::now();
  if (!next_trial(system, before)) {
    return fail(ErrorCode::kTimeout,
                "the session did not go on after " + text_of(pause) + "\n" + system.everything_printed());
  }
  pause.back_after_s = seconds_since(resumed);
  return pause;
}

Result<PauseReport> run(const PauseCampaign& campaign) {
  LiveSystem system(LiveSystem::Unattended::kYes, campaign.dds);
  std::mt19937_64 random(campaign.seed);
  PauseReport report;
  bool has_session = false;
  while (report.pauses.size() < campaign.pauses) {
    TONUS_TRY(keep_a_session(system, has_session));
    TONUS_TRY_ASSIGN(const Pause pause, pause_once(system, campaign, random));
    report.late += pause.back_after_s > kLimit_s ? 1 : 0;
    report.pauses.push_back(pause);
    if (campaign.prints_each) {
      fmt::print("{:3} {}\n", report.pauses.size(), text_of(pause));
      std::fflush(stdout);
    }
  }
  return report;
}

}  // namespace

Result<PauseReport> run_paused_sessions(const PauseCampaign& campaign) {
  try {
    return run(campaign);
  } catch (const std::exception& error) {
    return Error{ErrorCode::kInternal, error.what()};
  }
}

std::string text_of(const Pause& pause) {
  return fmt::format("{:.1f} s of {}: back after {:.1f} s", pause.seconds, pause.programs,
                     pause.back_after_s);
}

std::string text_of(const PauseReport& report) {
  std::vector<double> times;
  for (const Pause& pause : report.pauses) times.push_back(pause.back_after_s);
  std::ranges::sort(times);
  if (times.empty()) return "no pause\n";
  return fmt::format(
      "{} pauses: the next trial after {:.1f} s in the median, {:.1f} s at most; {} times later than {} s\n",
      times.size(), times[times.size() / 2], times.back(), report.late, kLimit_s);
}

}  // namespace tonus::testing
