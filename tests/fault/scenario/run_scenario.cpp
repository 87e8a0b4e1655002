// A session under a scenario, with an operator who clears and resumes, and an observer of what the rig does.
#include <array>
#include <chrono>
#include <csignal>
#include <map>
#include <spdlog/fmt/fmt.h>
#include <stdexcept>

#include "services/contract/names.hpp"
#include "tests/fault/rig/live_system.hpp"
#include "tests/fault/scenario/scenario.hpp"

namespace tonus::testing {
namespace {

using Time = std::chrono::steady_clock::time_point;

constexpr std::chrono::seconds kPatience{180};

/// Hears the rig and the scheduler, and keeps whether a trial may begin now.
class Observer {
 public:
  explicit Observer(LiveSystem& system) : system_(&system) {}

  /// What an operator has to do with before another trial may begin.
  void revoke(const std::string& because) { revoked_because_ = because; }
  void grant() { revoked_because_.clear(); }
  [[nodiscard]] const std::string& broken() const { return broken_; }

  /// Looks at what was heard last. A trial that was seen before is one that goes on.
  void look() {
    if (!system_->state()) return;
    const v1::RigState& rig = *system_->state();
    if (rig.mode() == v1::RIG_HELD) revoke("the rig is held: " + rig.held_because());
    if (rig.mode() != v1::RIG_IN_TRIAL || rig.trial_id() == trial_) return;
    trial_ = rig.trial_id();
    if (!revoked_because_.empty())
      broken_ += "a trial began without an operator's resume after: " + revoked_because_ + "\n";
  }

 private:
  LiveSystem* system_;
  std::array<std::uint8_t, 16> trial_{};
  std::string revoked_because_;
  std::string broken_;
};

/// A session, its steps, its operator.
class Run {
 public:
  explicit Run(const std::string& dds) : system_(LiveSystem::Unattended::kNo, dds), observer_(system_) {}

  Result<std::string> play(const Scenario& scenario) {
    system_.start_session(static_cast<int>(scenario.size()) + 2);
    if (!system_.wait_for_mid_trial(1, kPatience)) return stuck("no trial began");
    for (const Step& step : scenario) {
      pass(step.after);
      happen(step);
    }
    if (!listen([&] { return is_over(); }, kPatience + std::chrono::seconds(20 * scenario.size())))
      return stuck("the session does not end");
    if (const int code = system_.finish_session(kPatience); code != 0)
      broken_ += fmt::format("`tonus run` ended with {}\n", code);
    check_archive();
    return observer_.broken() + broken_;
  }

 private:
  Error stuck(const std::string& what) const {
    return Error{ErrorCode::kTimeout, what + '\n' + observer_.broken() + system_.everything_printed()};
  }

  /// Hears and lets the operator act until `is_true`.
  template <typename Condition>
  bool listen(const Condition& is_true, std::chrono::nanoseconds limit) {
    const Time deadline = std::chrono::steady_clock::now() + limit;
    while (!is_true()) {
      if (std::chrono::steady_clock::now() >= deadline) return false;
      (void)system_.listen_until([&] { return observer_.look(), is_true(); }, std::chrono::seconds(1));
      operate();
    }
    return true;
  }

  void pass(double seconds) {
    const Time until =
        std::chrono::steady_clock::now() + std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * seconds));
    (void)system_.listen_until([&] { return observer_.look(), std::chrono::steady_clock::now() >= until; },
                               std::chrono::seconds(60));
  }

  bool is_over() const { return system_.session() && v1::is_over(system_.session()->phase()); }

  bool waits_for(const char* text) const {
    return system_.session() && system_.session()->waiting_for().find(text) != std::string::npos;
  }

  /// Clears a rig that is held, then resumes what waits for it; each as often as it takes.
  void operate() {
    if (system_.state() && system_.state()->mode() == v1::RIG_HELD && waits_for("the rig is held")) {
      (void)system_.operate("clear-fault");
    } else if (waits_for("operator: resume")) {
      observer_.grant();  // before the request: the trial may begin before this program hears of its success
      if (system_.operate("resume") != 0) observer_.revoke("a resume that was refused");
    }
  }

  void happen(const Step& step) {
    const std::string name = "tonus-" + step.program;
    const bool moves = step.program == "rig-agent" || step.program == "scheduler";
    switch (step.act) {
      case Step::Act::kKill:
        if (!running(name)) return;
        kill(running_, SIGKILL);
        if (moves) observer_.revoke("kill of " + name);
        return;
      case Step::Act::kPause:
        if (!running(name)) return;
        kill(running_, SIGSTOP);
        pass(step.lasts);
        kill(running_, SIGCONT);
        return;
      case Step::Act::kRestart:
        system_.restart();
        observer_.revoke("restart of all programs");
        return;
      case Step::Act::kStop:
        if (system_.operate("stop") == 0) observer_.revoke("stop by the operator");
        return;
      default:
        throw std::invalid_argument("a step of simulated systems alone: " + to_text(Scenario{step}));
    }
  }

  /// The program, once its supervisor has it running.
  bool running(const std::string& name) {
    return system_.listen_until([&] { return observer_.look(), (running_ = system_.service(name)) != 0; },
                                std::chrono::seconds(30));
  }

  static std::string trials_of(const store::Session& session) {
    std::string text;
    for (const auto& trial : session.trials) {
      const std::string outcome =
          trial.outcome
              ? fmt::format("{} {}", v1::end_name(trial.outcome->value.end()), trial.outcome->value.detail())
              : "no outcome";
      const std::string verdict =
          trial.verdict
              ? (trial.verdict->value.is_valid() ? "valid" : "not valid: " + trial.verdict->value.detail())
              : "no verdict";
      text += fmt::format("attempt {}: {}; {}; {}\n", trial.attempt,
                          trial.command ? "commanded" : "no command", outcome, verdict);
    }
    return text;
  }

  void check_archive() {
    std::string missing;
    const auto is_whole = [&] { return (missing = missing_samples(system_.store_file())).empty(); };
    if (!system_.listen_until(is_whole, std::chrono::seconds(30))) broken_ += "samples: " + missing + '\n';
    const store::Session session = system_.archived();
    std::map<std::uint32_t, int> counted;
    for (const auto& trial : session.trials) {
      if (trial.verdict && trial.verdict->value.is_valid() && trial.outcome &&
          trial.outcome->value.end() == v1::TRIAL_COMPLETED)
        ++counted[trial.verdict->value.planned_index()];
    }
    if (counted.size() != session.record.planned_trials)
      broken_ +=
          fmt::format("{} of {} planned trials are counted\n", counted.size(), session.record.planned_trials);
    for (const auto& [index, times] : counted)
      if (times != 1) broken_ += fmt::format("planned trial {} is counted {} times\n", index + 1, times);
    broken_ += system_.verify_session();
    if (!broken_.empty()) broken_ += trials_of(session);
  }

  LiveSystem system_;
  Observer observer_;
  std::string broken_;
  pid_t running_ = 0;
};

}  // namespace

Result<std::string> run_scenario(const Scenario& scenario, const std::string& dds) {
  try {
    return Run(dds).play(scenario);
  } catch (const std::exception& error) {
    return Error{ErrorCode::kInternal, error.what()};
  }
}

}  // namespace tonus::testing
