#include "services/archive/session_reader.hpp"

#include <algorithm>
#include <map>
#include <spdlog/fmt/fmt.h>
#include <tuple>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/archive/sample_reader.hpp"
#include "services/bus/typed.hpp"

namespace tonus::archive {
namespace {

constexpr std::size_t kMostListed = 20;

/// Lower-case digits without hyphens.
std::string as_digits(std::string_view text) {
  std::string digits;
  for (const char c : text) {
    if (c != '-') digits += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return digits;
}

/// "2 sessions: <id> (subject, protocol, start); ...", the newest first.
std::string list_of(const std::vector<SessionRecord>& sessions) {
  std::string text = fmt::format("the store has {} sessions", sessions.size());
  std::size_t listed = 0;
  for (auto s = sessions.rbegin(); s != sessions.rend() && listed < kMostListed; ++s, ++listed) {
    text += fmt::format("{} {} ({}, {}, {})", listed == 0 ? ":" : ";", to_hex(s->session), s->subject,
                        s->protocol_name, s->started_at);
  }
  if (sessions.size() > listed) text += fmt::format("; and {} older ones", sessions.size() - listed);
  return text;
}

/// Keeps what was in force when the session began and what replaced it since, by a message's key.
template <typename T>
class InForce {
 public:
  void take(const Id& key, Arrival<T> arrival, bool has_begun) {
    if (has_begun) {
      since_.push_back(std::move(arrival));
    } else {
      before_.insert_or_assign(key, std::move(arrival));
    }
  }

  [[nodiscard]] std::vector<Arrival<T>> all() && {
    std::vector<Arrival<T>> all;
    for (auto& [key, arrival] : before_) all.push_back(std::move(arrival));
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return a.received_ns < b.received_ns; });
    std::move(since_.begin(), since_.end(), std::back_inserter(all));
    return all;
  }

 private:
  std::map<Id, Arrival<T>> before_;
  std::vector<Arrival<T>> since_;
};

/// Sorts one session's messages out of all.
class SessionCollector {
 public:
  explicit SessionCollector(SessionRecord record) { session_.record = std::move(record); }

  /// Messages in the order of their coming.
  void take(const Message& message) {
    const bool is_ours = message.session == id();
    has_begun_ |= is_ours;
    take_session_messages(message);
    take_trial_messages(message);
    // What belongs to no session: of another session's time only what was before this one.
    if (is_ours || !has_begun_) take_surroundings(message);
  }

  /// kNotFound without a plan.
  [[nodiscard]] Result<Session> finish(std::vector<TrialRecord> records) && {
    if (!has_plan_) {
      return fail(ErrorCode::kNotFound,
                  fmt::format("session {}: its plan is missing in the store", to_hex(id())));
    }
    for (TrialRecord& record : records) {
      auto& trial = trials_[record.attempt];
      trial.trial = record.trial;
      trial.record = std::move(record);
    }
    for (auto& [attempt, trial] : trials_) {
      trial.attempt = attempt;
      session_.trials.push_back(std::move(trial));
    }
    session_.descriptions = std::move(descriptions_).all();
    session_.configurations = std::move(configurations_).all();
    session_.clock_offsets = std::move(clock_offsets_).all();
    return std::move(session_);
  }

 private:
  [[nodiscard]] const Id& id() const { return session_.record.session; }

  /// Decodes where the message is of this topic; one that cannot be decoded is noted.
  template <typename T>
  std::optional<Arrival<T>> decode(const Message& message, const topics::Topic<T>& topic) {
    if (message.topic != topic.spec.name) return {};
    auto value = bus::decode<T>(*message.payload);
    if (value) return Arrival<T>{std::move(*value), message.received_ns};
    if (message.session == id())
      session_.undecodable.push_back(fmt::format("{}: {}", message.topic, value.error().message));
    return {};
  }

  void take_session_messages(const Message& message) {
    if (message.key == id()) {
      if (auto plan = decode(message, topics::kSessionPlan)) {
        session_.plan = std::move(plan->value);
        has_plan_ = true;
      }
      if (auto state = decode(message, topics::kSessionState)) session_.state = std::move(state->value);
      if (auto command = decode(message, topics::kSessionCommand))
        session_.commands.push_back(std::move(*command));
      if (auto reply = decode(message, topics::kSessionReply)) session_.replies.push_back(std::move(*reply));
    }
    if (auto estimate = decode(message, topics::kEstimateCondition);
        estimate && estimate->value.session_id() == id()) {
      session_.estimates.push_back(std::move(*estimate));
    }
  }

  void take_trial_messages(const Message& message) {
    if (auto command = decode(message, topics::kTrialCommand);
        command && command->value.program().session_id() == id()) {
      auto& trial = trials_[command->value.program().attempt()];
      trial.trial = command->value.trial_id();
      if (!trial.command) trial.command = std::move(command);
    }
    if (auto outcome = decode(message, topics::kTrialOutcome);
        outcome && outcome->value.program().session_id() == id()) {
      auto& trial = trials_[outcome->value.program().attempt()];
      trial.trial = outcome->value.trial_id();
      trial.outcome = std::move(outcome);
    }
    if (auto verdict = decode(message, topics::kTrialVerdict);
        verdict && verdict->value.session_id() == id()) {
      auto& trial = trials_[verdict->value.attempt()];
      trial.trial = verdict->value.trial_id();
      trial.verdict = std::move(verdict);
    }
  }

  void take_surroundings(const Message& message) {
    if (message.key == session_.record.rig) {
      if (auto description = decode(message, topics::kRigDescription))
        descriptions_.take(message.key, std::move(*description), has_begun_);
      if (has_begun_) {
        if (auto command = decode(message, topics::kRigCommand))
          session_.rig_commands.push_back(std::move(*command));
        if (auto reply = decode(message, topics::kRigReply))
          session_.rig_replies.push_back(std::move(*reply));
      }
    }
    if (auto configuration = decode(message, topics::kServiceConfiguration))
      configurations_.take(message.key, std::move(*configuration), has_begun_);
    if (auto offset = decode(message, topics::kClockOffset))
      clock_offsets_.take(message.key, std::move(*offset), has_begun_);
  }

  Session session_;
  bool has_begun_ = false;
  bool has_plan_ = false;
  std::map<std::uint32_t, SessionTrial> trials_;
  InForce<v1::RigDescription> descriptions_;
  InForce<v1::ServiceConfiguration> configurations_;
  InForce<v1::ClockOffset> clock_offsets_;
};

}  // namespace

Result<SessionRecord> find_session(Store& store, std::string_view wanted) {
  auto sessions = store.sessions();
  if (!sessions) return sessions.error();
  const auto refuse = [&](ErrorCode code, std::string_view why) {
    return fail(
        code, fmt::format("session '{}': {}: store '{}': {}", wanted, why, store.name(), list_of(*sessions)));
  };
  if (sessions->empty()) return refuse(ErrorCode::kNotFound, "is not there");
  if (wanted.empty() || wanted == "last") return sessions->back();
  const std::string prefix = as_digits(wanted);
  std::erase_if(*sessions, [&](const SessionRecord& s) { return !to_hex(s.session).starts_with(prefix); });
  if (sessions->size() == 1) return sessions->front();
  if (!sessions->empty()) return refuse(ErrorCode::kInvalidArgument, "more than one begins so");
  sessions = store.sessions();
  if (!sessions) return sessions.error();
  return refuse(ErrorCode::kNotFound, "is not there");
}

Certificate Session::certificate() const {
  Certificate sum;
  for (const SessionTrial& trial : trials) {
    if (!trial.record) continue;
    const Certificate& one = trial.record->certificate;
    sum.expected += one.expected;
    sum.received += one.received;
    sum.resent += one.resent;
    sum.duplicated += one.duplicated;
    sum.missing += one.missing;
  }
  return sum;
}

bool Session::is_whole() const {
  return std::all_of(trials.begin(), trials.end(), [](const SessionTrial& trial) {
    return trial.outcome && trial.record && trial.record->is_certified;
  });
}

Result<Session> read_session(Store& store, const Id& session) {
  const auto sessions = store.sessions();
  if (!sessions) return sessions.error();
  const auto record = std::find_if(sessions->begin(), sessions->end(),
                                   [&](const SessionRecord& s) { return s.session == session; });
  if (record == sessions->end()) {
    return fail(ErrorCode::kNotFound,
                fmt::format("session {}: is not in store '{}'", to_hex(session), store.name()));
  }
  SessionCollector collector(*record);
  const auto visited = store.visit_messages({}, [&](const Message& message) -> Result<void> {
    collector.take(message);
    return {};
  });
  if (!visited) return visited.error();
  auto trials = store.trials(session);
  if (!trials) return trials.error();
  return std::move(collector).finish(std::move(*trials));
}

std::vector<v1::Estimate> newest_estimates(const Session& session) {
  std::map<Id, const v1::Estimate*> newest;
  for (const auto& estimate : session.estimates) newest[estimate.value.estimate_id()] = &estimate.value;
  std::vector<v1::Estimate> all;
  for (const auto& [id, estimate] : newest) all.push_back(*estimate);
  const auto place = [](const v1::Estimate& e) {
    return std::tuple(e.posture_index(), e.set_number(), e.bias_N(), e.instruction(), e.method(), e.model());
  };
  std::stable_sort(all.begin(), all.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  return all;
}

Result<std::vector<v1::RigSample>> read_trial_samples(Store& store, const SessionTrial& trial) {
  if (!trial.record || !trial.record->has_samples) {
    return fail(ErrorCode::kNotFound,
                fmt::format("trial {}: has no samples in store '{}'", trial.attempt, store.name()));
  }
  return read_samples(store, trial.record->stream, trial.record->range());
}

}  // namespace tonus::archive
