#include "services/cli/session_run.hpp"

#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/offline/results_json.hpp"
#include "analysis_service/study/loaded_postures.hpp"
#include "services/cli/condition_text.hpp"
#include "services/cli/progress_bar.hpp"
#include "services/cli/recording_protocol.hpp"
#include "services/cli/results.hpp"
#include "services/contract/names.hpp"
#include "services/contract/subject.hpp"
#include "services/core/json_text.hpp"
#include "services/protocol/protocol_file.hpp"
#include "services/runtime/options.hpp"
#include "services/simulation/true_impedance.hpp"

namespace tonus::cli {
namespace {

constexpr std::chrono::seconds kReplyLimit{10};
constexpr std::chrono::milliseconds kTick{100};
constexpr std::chrono::seconds kLook{2};
constexpr std::chrono::seconds kQuestion{5};

bool is_over(const std::optional<v1::SessionState>& state) { return state && v1::is_over(state->phase()); }

std::string remark_of(const v1::SessionState& state) {
  std::string remark = state.posture();
  if (state.rejected() > 0) remark += fmt::format(", {} rejected", state.rejected());
  return remark;
}

/// Says of a precision-led condition once why it has ended. `said`: what was.
void say_finished(const v1::SessionState& state, std::map<std::string, std::string>& said,
                  ProgressBar& progress) {
  for (const auto& condition : state.conditions()) {
    if (!condition.is_finished() || !(condition.precision_goal() > 0.0)) continue;
    const std::string name =
        fmt::format("{} {} {}", condition.posture(), condition.set_number(), condition.instruction());
    if (std::exchange(said[name], condition.finished_because()) == condition.finished_because()) continue;
    progress.say(condition_text(condition));
  }
}

/// Truth of the simulated subject; none for any other rig.
Result<Truth> truth_of(const std::optional<v1::RigDescription>& rig, const std::string& profile_file) {
  if (!rig || rig->driver() != "simulated") return Truth{};
  simulation::Profile profile;
  if (!profile_file.empty()) {
    auto loaded = simulation::load_profile(profile_file);
    if (!loaded) return loaded.error();
    profile = *loaded;
  }
  return Truth{
      [subject = profile.subject](const v1::Estimate& e) -> std::optional<simulation::CartesianImpedance> {
        return simulation::true_impedance(subject, {e.posture_m()[0], e.posture_m()[1]},
                                          simulation::instruction_named(e.instruction()));
      }};
}

/// The rejected trials of a session's posture: a verdict names its trial's place in the plan, which belongs
/// to one posture.
std::vector<identification::LeftOut> rejected_of(const std::vector<v1::TrialVerdict>& verdicts,
                                                 const v1::Estimate& estimate) {
  std::vector<identification::LeftOut> rejected;
  for (const auto& verdict : verdicts) {
    if (verdict.posture_index() == estimate.posture_index())
      rejected.push_back({verdict.attempt(), verdict.detail()});
  }
  return rejected;
}

Result<void> print_results(const SessionClient& client, const Id& session, const RunOptions& options) {
  auto truth = truth_of(client.rig(), options.profile);
  if (!truth) return truth.error();
  const auto estimates = client.estimates(session);
  std::fputs("\n", stdout);
  for (const auto& estimate : estimates) std::printf("%s\n", as_text(estimate, *truth).c_str());
  for (const auto& posture : study::loaded_postures(estimates))
    std::printf("%s\n", study::as_text(posture).c_str());
  for (const auto& verdict : client.rejections(session)) {
    std::printf("trial %u rejected: %s\n", verdict.attempt(), verdict.detail().c_str());
  }
  std::fflush(stdout);
  if (options.json.empty()) return {};
  std::vector<identification::OfflineEstimate> results;
  results.reserve(estimates.size());
  for (const auto& estimate : estimates) {
    results.push_back({options.subject,
                       to_hex(session),
                       static_cast<int>(estimate.posture_index()) + 1,
                       {},
                       rejected_of(client.rejections(session), estimate),
                       estimate});
  }
  nlohmann::json json = identification::json_of(results);
  json["progress"] = nlohmann::json::array();
  if (const auto& state = client.state(session)) {
    for (const auto& condition : state->conditions()) json["progress"].push_back(condition_json(condition));
  }
  json["loaded"] = as_json(study::loaded_postures(estimates));
  return options.results->write(json_text(json) + "\n");
}

/// What an operator types when a session waits for one; empty where it does not.
std::string what_to_type(const std::string& waiting_for) {
  if (!waiting_for.starts_with("operator: ")) return {};
  const bool is_held = waiting_for.find("rig is held") != std::string::npos;
  return is_held ? "\n  type: tonus clear-fault; then: tonus resume" : "\n  type: tonus resume";
}

/// Starts a session; its id.
Result<Id> start_session(SessionClient& client, const RunOptions& options) {
  TONUS_TRY_ASSIGN(const auto text, protocol_text(options));
  v1::SessionCommand start;
  start.session_id(random_id());
  start.request(v1::SESSION_START);
  start.protocol_toml(text);
  TONUS_TRY(put_people(options.people, options.subject, start));
  start.seed(options.seed);
  TONUS_TRY(client.request(start, kReplyLimit));
  return start.session_id();
}

/// The session that goes on.
Result<Id> running_session(SessionClient& client, const std::function<int()>& interruptions) {
  const auto is_going = [&] { return client.newest_state() && !is_over(client.newest_state()); };
  const bool is_heard = client.wait_for(is_going, kLook, [&] { return interruptions() > 0; }).has_value();
  if (interruptions() > 0) return fail(ErrorCode::kUnavailable, std::string(runtime::kInterruptedText));
  if (!is_heard) return fail(ErrorCode::kNotFound, "no session is going on");
  return client.newest_state()->session_id();
}

/// What Ctrl-C does to the session: leaves it, or aborts it.
class Leaving {
 public:
  enum class Answer { kStay, kLeave, kAbort };

  Leaving(bool detaches, const Clock& clock) : detaches_(detaches), clock_(clock) {}

  Answer ask(int interruptions, ProgressBar& progress) {
    if (interruptions == 0 || has_aborted_) return Answer::kStay;
    if (!detaches_ || interruptions > 1) {
      has_aborted_ = true;
      return Answer::kAbort;
    }
    if (!is_asked_) {
      is_asked_ = true;
      leaves_at_ = clock_.now() + kQuestion;
      progress.say(fmt::format("leave the session to itself? Ctrl-C again within {} s aborts it instead",
                               kQuestion.count()));
    }
    return clock_.now() < leaves_at_ ? Answer::kStay : Answer::kLeave;
  }

 private:
  const bool detaches_;
  const Clock& clock_;
  bool is_asked_ = false;
  Clock::TimePoint leaves_at_;
  bool has_aborted_ = false;
};

}  // namespace

Result<void> check_people(const RunOptions& options) {
  v1::SessionCommand start;
  return put_people(options.people, options.subject, start);
}

Result<std::string> protocol_text(const RunOptions& options) {
  if (!options.dataset.empty()) return recording_protocol(options.dataset);
  // Checked here so that a message names the file; the scheduler checks again what it gets.
  auto protocol = protocol::load_protocol(options.protocol);
  if (!protocol) return protocol.error();
  return protocol->text;
}

Result<void> run_session(SessionClient& client, const RunOptions& options, const Clock& clock,
                         const std::function<Result<void>()>& tick,
                         const std::function<int()>& interruptions) {
  const auto begun = clock.now();
  const auto started =
      options.attaches ? running_session(client, interruptions) : start_session(client, options);
  if (!started) return started.error();
  const Id session = *started;
  std::printf(options.is_brief ? "session %s; " : "session %s\n", to_hex(session).c_str());
  std::fflush(stdout);

  ProgressBar progress("trials");
  std::string waited_for;
  std::map<std::string, std::string> finished;
  Leaving leaving(options.detaches, clock);
  while (!is_over(client.state(session))) {
    (void)client.wait_for([&] { return is_over(client.state(session)); }, kTick);
    if (auto ticked = tick(); !ticked) return ticked;
    if (const auto& state = client.state(session)) {
      if (state->waiting_for() != waited_for && !state->waiting_for().empty())
        progress.say("the session waits for " + state->waiting_for() + what_to_type(state->waiting_for()));
      waited_for = state->waiting_for();
      say_finished(*state, finished, progress);
      progress.show(state->counted(), state->planned(), remark_of(*state));
    }
    switch (leaving.ask(interruptions(), progress)) {
      case Leaving::Answer::kStay:
        break;
      case Leaving::Answer::kLeave:
        progress.clear();
        std::printf("the session goes on; to watch it again, type: tonus run --attach\n");
        return {};
      case Leaving::Answer::kAbort: {
        v1::SessionCommand abort;
        abort.session_id(session);
        abort.request(v1::SESSION_ABORT);
        progress.say("the session is being aborted");
        TONUS_TRY(client.request(abort, kReplyLimit));
      }
    }
  }
  progress.clear();
  const auto state = *client.state(session);
  if (state.phase() != v1::SESSION_COMPLETED) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("the session was {} after {} of {} trials: {}",
                            state.phase() == v1::SESSION_ABORTED ? "aborted" : "ended by a failure",
                            state.counted(), state.planned(), state.message()));
  }
  // The last verdict ends the session; the estimate that it leads to follows.
  if (!client.wait_for([&] { return client.has_estimated_every_valid_trial(session); }, kReplyLimit)) {
    std::fputs("tonus: the newest estimates have not arrived; the last trials are not in the results below\n",
               stderr);
  }
  const double wall = std::chrono::duration<double>(clock.now() - begun).count();
  if (!options.is_brief) {
    if (auto printed = print_results(client, session, options); !printed) return printed;
  }
  std::printf("%u trials, %u rejected; %.1f s of experiment in %.1f s, %.0f times real time\n",
              state.counted(), state.rejected(), state.experiment_s(), wall, state.experiment_s() / wall);
  std::fflush(stdout);
  if (state.counted() < state.planned()) {
    return fail(ErrorCode::kDataLoss,
                fmt::format("{} of {} planned trials could not be used; the reasons are above",
                            state.planned() - state.counted(), state.planned()));
  }
  return {};
}

}  // namespace tonus::cli
