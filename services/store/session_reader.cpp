#include "services/store/session_reader.hpp"

#include <algorithm>
#include <map>
#include <spdlog/fmt/fmt.h>
#include <tuple>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/contract/review.hpp"
#include "services/core/text.hpp"
#include "services/store/stored_message.hpp"

namespace tonus::store {
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

/// "has 2 sessions: <id> (subject, protocol, start); ...", the newest first.
std::string list_of(const std::vector<SessionRecord>& sessions) {
  std::string text = fmt::format("has {} sessions", sessions.size());
  std::size_t listed = 0;
  for (auto s = sessions.rbegin(); s != sessions.rend() && listed < kMostListed; ++s, ++listed) {
    text += fmt::format("{} {} ({}, {}, {})", listed == 0 ? ":" : ";", to_hex(s->session), s->subject,
                        s->protocol_name, s->started_at);
  }
  if (sessions.size() > listed) text += fmt::format("; and {} older ones", sessions.size() - listed);
  return text;
}

/// Lists in the order of arrival; what was in force at the begin comes first.
template <typename T>
void sort_by_arrival(std::vector<Arrival<T>>& list) {
  std::stable_sort(list.begin(), list.end(),
                   [](const auto& a, const auto& b) { return a.received_ns < b.received_ns; });
}

/// Puts one session together from its messages.
class SessionCollector {
 public:
  explicit SessionCollector(SessionRecord record) { session_.record = std::move(record); }

  /// A message whose key is the session.
  void take_session_message(const Message& message) {
    if (auto plan = decode(message, topics::kSessionPlan)) {
      session_.plan = std::move(plan->value);
      has_plan_ = true;
    }
    if (auto state = decode(message, topics::kSessionState)) session_.state = std::move(state->value);
    if (auto command = decode(message, topics::kSessionCommand))
      session_.commands.push_back(std::move(*command));
    if (auto reply = decode(message, topics::kSessionReply)) session_.replies.push_back(std::move(*reply));
  }

  /// A trial's message or an estimate, of this session or of another one.
  void take_result(const Message& message) {
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
    if (auto review = decode(message, topics::kTrialReview); review && review->value.session_id() == id()) {
      auto& trial = trials_[review->value.attempt()];
      trial.trial = review->value.trial_id();
      trial.review = std::move(review);
    }
    if (auto note = decode(message, topics::kSessionNote); note && note->value.session_id() == id())
      notes_.insert_or_assign(note->value.note_id(), std::move(*note));
    if (auto estimate = decode(message, topics::kEstimateCondition);
        estimate && estimate->value.session_id() == id()) {
      session_.estimates.push_back(std::move(*estimate));
    }
  }

  /// A message that belongs to no session: of the rig, or of the services.
  void take_surroundings(const Message& message) {
    if (message.key == session_.record.rig) {
      if (auto description = decode(message, topics::kRigDescription))
        session_.descriptions.push_back(std::move(*description));
      if (auto command = decode(message, topics::kRigCommand))
        session_.rig_commands.push_back(std::move(*command));
      if (auto reply = decode(message, topics::kRigReply)) session_.rig_replies.push_back(std::move(*reply));
    }
    if (auto configuration = decode(message, topics::kServiceConfiguration))
      session_.configurations.push_back(std::move(*configuration));
    if (auto offset = decode(message, topics::kClockOffset))
      session_.clock_offsets.push_back(std::move(*offset));
  }

  /// After what was in force at the begin, and before what came during the session.
  void begin() {
    sort_by_arrival(session_.descriptions);
    sort_by_arrival(session_.configurations);
    sort_by_arrival(session_.clock_offsets);
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
      trial.record->posture = masked(std::move(trial.record->posture), TextKind::kLine);
    }
    for (auto& [attempt, trial] : trials_) {
      trial.attempt = attempt;
      session_.trials.push_back(std::move(trial));
    }
    for (auto& [key, note] : notes_) session_.notes.push_back(std::move(note));
    std::stable_sort(session_.notes.begin(), session_.notes.end(), [](const auto& a, const auto& b) {
      return a.value.written_ns() < b.value.written_ns();
    });
    return std::move(session_);
  }

 private:
  [[nodiscard]] const Id& id() const { return session_.record.session; }

  /// Decodes where the message is of this topic; one of the session that cannot be decoded is noted.
  template <typename T>
  std::optional<Arrival<T>> decode(const Message& message, const topics::Topic<T>& topic) {
    if (message.topic != topic.spec.name) return {};
    auto value = decode_stored<T>(*message.payload);
    if (value) return Arrival<T>{std::move(*value), message.received_ns};
    if (message.session == id())
      session_.undecodable.push_back(fmt::format("{}: {}", message.topic, value.error().message));
    return {};
  }

  Session session_;
  bool has_plan_ = false;
  std::map<std::uint32_t, SessionTrial> trials_;
  std::map<Id, Arrival<v1::SessionNote>> notes_;  // once each: a restarted scheduler publishes them anew
};

using Take = void (SessionCollector::*)(const Message&);

Result<void> collect(Store& store, const MessageQuery& query, SessionCollector& collector, Take take) {
  return store.visit_messages(query, [&](const Message& message) -> Result<void> {
    (collector.*take)(message);
    return {};
  });
}

/// The session that began next; none where this is the newest.
std::optional<Id> successor_of(const std::vector<SessionRecord>& sessions, const Id& session) {
  const auto place = std::find_if(sessions.begin(), sessions.end(),
                                  [&](const SessionRecord& s) { return s.session == session; });
  if (place == sessions.end() || std::next(place) == sessions.end()) return {};
  return std::next(place)->session;
}

/// Asks the store for what belongs to the session, by key and by session, never for all that it has.
Result<void> collect_session(Store& store, const Id& session, const std::optional<Id>& successor,
                             SessionCollector& collector) {
  for (const std::string_view topic : kSurroundingTopics) {
    const MessageQuery query{std::string(topic), {}, {}, false, session};
    TONUS_TRY(collect(store, query, collector, &SessionCollector::take_surroundings));
  }
  collector.begin();
  TONUS_TRY(store.visit_messages({{}, session, {}}, [&](const Message& message) -> Result<void> {
    collector.take_result(message);
    collector.take_surroundings(message);
    return {};
  }));
  for (const bus::TopicSpec* topic : {&topics::kSessionPlan.spec, &topics::kSessionState.spec,
                                      &topics::kSessionCommand.spec, &topics::kSessionReply.spec}) {
    const MessageQuery query{std::string(topic->name), {}, session};
    TONUS_TRY(collect(store, query, collector, &SessionCollector::take_session_message));
  }
  if (!successor) return {};
  // What was late is archived under the session that had begun by then.
  for (const bus::TopicSpec* topic :
       {&topics::kTrialCommand.spec, &topics::kTrialOutcome.spec, &topics::kTrialVerdict.spec,
        &topics::kTrialReview.spec, &topics::kSessionNote.spec, &topics::kEstimateCondition.spec}) {
    const MessageQuery query{std::string(topic->name), *successor, {}};
    TONUS_TRY(collect(store, query, collector, &SessionCollector::take_result));
  }
  return {};
}

}  // namespace

Result<std::vector<SessionRecord>> list_sessions(Store& store) {
  TONUS_TRY_ASSIGN(auto sessions, store.sessions());
  for (SessionRecord& session : sessions) {
    for (std::string* text :
         {&session.subject, &session.protocol_name, &session.started_at, &session.software_version})
      *text = masked(std::move(*text), TextKind::kLine);
  }
  return sessions;
}

Result<SessionRecord> find_session(Store& store, std::string_view wanted) {
  TONUS_TRY_ASSIGN(const auto sessions, list_sessions(store));
  const auto refuse = [&](ErrorCode code, std::string_view why, const std::vector<SessionRecord>& listed) {
    return fail(code,
                fmt::format("session '{}': {}; store '{}' {}", wanted, why, store.name(), list_of(listed)));
  };
  if (sessions.empty()) return refuse(ErrorCode::kNotFound, "not found", sessions);
  if (wanted.empty() || wanted == "last") return sessions.back();
  const std::string prefix = as_digits(wanted);
  std::vector<SessionRecord> matches;
  std::copy_if(sessions.begin(), sessions.end(), std::back_inserter(matches),
               [&](const SessionRecord& s) { return to_hex(s.session).starts_with(prefix); });
  if (matches.size() == 1) return matches.front();
  if (matches.empty()) return refuse(ErrorCode::kNotFound, "not found", sessions);
  return refuse(ErrorCode::kInvalidArgument, "is ambiguous", matches);
}

Certificate Session::certificate() const {
  Certificate sum;
  for (const SessionTrial& trial : trials) {
    if (trial.record) sum += trial.record->certificate;
  }
  return sum;
}

bool Session::is_whole() const {
  return std::all_of(trials.begin(), trials.end(), [](const SessionTrial& trial) {
    return trial.outcome && trial.record && trial.record->is_certified;
  });
}

std::optional<v1::TrialVerdict> standing_verdict(const SessionTrial& trial) {
  if (!trial.verdict) return std::nullopt;
  return contract::standing_verdict(trial.verdict->value, trial.review ? &trial.review->value : nullptr);
}

std::uint32_t attempt_of(const Session& session, const v1::SessionNote& note) {
  if (note.trial_id() == kNoId) return 0;
  const auto found = std::ranges::find(session.trials, note.trial_id(), &SessionTrial::trial);
  return found == session.trials.end() ? 0 : found->attempt;
}

std::string why_not_counted(const SessionTrial& trial) {
  const auto verdict = standing_verdict(trial);
  if (!verdict) return "no verdict";
  if (verdict->is_valid()) return {};
  return verdict->detail().empty() ? "judged invalid" : verdict->detail();
}

Result<Session> read_session(Store& store, const Id& session) {
  TONUS_TRY_ASSIGN(const auto sessions, list_sessions(store));
  const auto record = std::find_if(sessions.begin(), sessions.end(),
                                   [&](const SessionRecord& s) { return s.session == session; });
  if (record == sessions.end()) {
    return fail(ErrorCode::kNotFound,
                fmt::format("session {}: is not in store '{}'", to_hex(session), store.name()));
  }
  SessionCollector collector(*record);
  TONUS_TRY(collect_session(store, session, successor_of(sessions, session), collector));
  TONUS_TRY_ASSIGN(auto trials, store.trials(session));
  return std::move(collector).finish(std::move(trials));
}

Result<Session> read_found_session(Store& store, std::string_view wanted) {
  TONUS_TRY_ASSIGN(const auto record, find_session(store, wanted));
  return read_session(store, record.session);
}

void sort_by_condition(std::vector<v1::Estimate>& estimates) {
  const auto place = [](const v1::Estimate& e) {
    return std::tuple(e.posture_index(), e.set_number(), e.bias_N(), e.instruction(), e.method(), e.model());
  };
  std::stable_sort(estimates.begin(), estimates.end(),
                   [&](const auto& a, const auto& b) { return place(a) < place(b); });
}

std::vector<v1::Estimate> newest_estimates(const Session& session) {
  std::map<Id, const v1::Estimate*> newest;
  for (const auto& estimate : session.estimates) newest[estimate.value.estimate_id()] = &estimate.value;
  std::vector<v1::Estimate> all;
  all.reserve(newest.size());
  for (const auto& [id, estimate] : newest) all.push_back(*estimate);
  sort_by_condition(all);
  return all;
}

}  // namespace tonus::store
