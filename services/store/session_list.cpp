#include "services/store/session_list.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/contract/names.hpp"
#include "services/contract/subject.hpp"
#include "services/store/session_reader.hpp"
#include "services/store/stored_message.hpp"

namespace tonus::store {
namespace {

/// The plan as far as the record has it.
v1::SessionPlan plan_of(const SessionRecord& record) {
  v1::SessionPlan plan;
  plan.session_id(record.session);
  plan.rig_id(record.rig);
  plan.subject(record.subject);
  plan.subject_facts(contract::unknown_subject());
  plan.protocol_name(record.protocol_name);
  plan.seed(record.seed);
  plan.planned_trials(record.planned_trials);
  plan.started_at(record.started_at);
  plan.software_version(record.software_version);
  return plan;
}

/// Calls `take` with each message of the topic that can be decoded, in the order of arrival.
template <typename T, typename Take>
Result<void> visit_decoded(Store& store, const topics::Topic<T>& topic, Take take) {
  const MessageQuery query{std::string(topic.spec.name), {}, {}, true};
  return store.visit_messages(query, [&](const Message& message) -> Result<void> {
    if (!check(message, {})) return {};
    if (auto value = decode_stored<T>(*message.payload)) take(std::move(*value));
    return {};
  });
}

StudySession study_session_of(const SessionSummary& session) {
  StudySession entry{
      session.record.session,        session.record.protocol_name, session.record.started_at, {}, 0,
      session.record.planned_trials, session.plan.is_pilot()};
  if (session.state) {
    entry.phase = session.state->phase();
    entry.counted = session.state->counted();
    entry.planned = session.state->planned();
  }
  return entry;
}

}  // namespace

bool SessionSummary::is_completed() const { return state && state->phase() == v1::SESSION_COMPLETED; }

Result<std::vector<SessionSummary>> summarise_sessions(Store& store) {
  TONUS_TRY_ASSIGN(auto records, list_sessions(store));
  std::vector<SessionSummary> sessions;
  std::map<Id, std::size_t> places;
  for (SessionRecord& record : records) {
    places[record.session] = sessions.size();
    v1::SessionPlan plan = plan_of(record);
    sessions.push_back({std::move(record), std::move(plan), {}});
  }
  TONUS_TRY(visit_decoded(store, topics::kSessionPlan, [&](v1::SessionPlan plan) {
    const auto place = places.find(plan.session_id());
    if (place != places.end()) sessions[place->second].plan = std::move(plan);
  }));
  TONUS_TRY(visit_decoded(store, topics::kSessionState, [&](v1::SessionState state) {
    const auto place = places.find(state.session_id());
    if (place != places.end()) sessions[place->second].state = std::move(state);
  }));
  return sessions;
}

std::vector<KnownSubject> subjects_of(const std::vector<SessionSummary>& sessions) {
  std::map<std::string, KnownSubject> subjects;
  for (const SessionSummary& session : sessions) {
    const auto [place, is_new] = subjects.try_emplace(session.record.subject);
    KnownSubject& subject = place->second;
    if (is_new) {
      subject.subject = session.record.subject;
      subject.facts = contract::unknown_subject();
    }
    contract::update_facts(subject.facts, session.plan.subject_facts());
    ++subject.sessions;
    subject.pilot_sessions += session.plan.is_pilot() ? 1 : 0;
    subject.last = session.record;
  }
  std::vector<KnownSubject> list;
  list.reserve(subjects.size());
  for (auto& [name, subject] : subjects) list.push_back(std::move(subject));
  return list;
}

Result<std::vector<KnownSubject>> list_subjects(Store& store) {
  TONUS_TRY_ASSIGN(const auto sessions, summarise_sessions(store));
  return subjects_of(sessions);
}

bool StudySession::is_done() const { return phase == v1::SESSION_COMPLETED && !is_pilot; }

bool StudySubjectProgress::has_done(std::string_view protocol_name) const {
  return std::ranges::any_of(sessions, [&](const StudySession& session) {
    return session.is_done() && session.protocol_name == protocol_name;
  });
}

std::size_t StudySubjectProgress::done() const {
  return static_cast<std::size_t>(std::ranges::count_if(sessions, &StudySession::is_done));
}

std::vector<StudySubjectProgress> progress_of(const std::vector<SessionSummary>& sessions,
                                              std::string_view study) {
  std::map<std::string, StudySubjectProgress> subjects;
  for (const SessionSummary& session : sessions) {
    if (study.empty() || session.plan.study() != study) continue;
    StudySubjectProgress& subject = subjects[session.record.subject];
    subject.subject = session.record.subject;
    subject.sessions.push_back(study_session_of(session));
  }
  std::vector<StudySubjectProgress> list;
  list.reserve(subjects.size());
  for (auto& [name, subject] : subjects) list.push_back(std::move(subject));
  return list;
}

Result<std::vector<StudySubjectProgress>> study_progress(Store& store, std::string_view study) {
  TONUS_TRY_ASSIGN(const auto sessions, summarise_sessions(store));
  return progress_of(sessions, study);
}

std::vector<std::string> studies_of(const std::vector<SessionSummary>& sessions) {
  std::set<std::string> names;
  for (const SessionSummary& session : sessions) {
    if (!session.plan.study().empty()) names.insert(session.plan.study());
  }
  return {names.begin(), names.end()};
}

}  // namespace tonus::store
