#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "idl/topics.hpp"
#include "services/core/result.hpp"
#include "services/store/store.hpp"

#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/service.h>
#include <idl/session.h>
#include <idl/trial.h>

/// Whole sessions out of a store, decoded. Reads only; a store may be written by its archive at the same
/// time.
namespace tonus::store {

/// All sessions as Store::sessions() gives them, each text one line, fit to be shown.
[[nodiscard]] Result<std::vector<SessionRecord>> list_sessions(Store& store);

/// The session that a person means by `wanted`: its id or the beginning of it (hexadecimal, hyphens allowed);
/// empty or "last": the one that began last. kNotFound: there is none; kInvalidArgument: several begin like
/// that. Both messages list sessions to choose from.
[[nodiscard]] Result<SessionRecord> find_session(Store& store, std::string_view wanted);

/// A message's content, and when the archive received it, ns of UTC.
template <typename T>
struct Arrival {
  T value;
  std::uint64_t received_ns = 0;
};

/// One attempt at a planned trial.
struct SessionTrial {
  std::uint32_t attempt = 0;
  Id trial{};
  std::optional<Arrival<v1::TrialCommand>> command;
  std::optional<Arrival<v1::TrialOutcome>> outcome;  ///< None while the trial runs.
  std::optional<Arrival<v1::TrialVerdict>> verdict;  ///< The newest, as published; see standing_verdict().
  std::optional<Arrival<v1::TrialReview>> review;    ///< The newest.
  std::optional<TrialRecord> record;                 ///< With its certificate; there with the outcome.
};

/// What the archive has of one session. Lists are in the order of arrival where nothing else is said.
struct Session {
  SessionRecord record;
  v1::SessionPlan plan;
  std::optional<v1::SessionState> state;  ///< The newest; none before the scheduler's first one.

  /// Of the session's rig: the one in force when the session began (or the first one after), and those that
  /// replaced it while it was run.
  std::vector<Arrival<v1::RigDescription>> descriptions;

  std::vector<SessionTrial> trials;              ///< By attempt.
  std::vector<Arrival<v1::Estimate>> estimates;  ///< Every one that was published, in time.

  std::vector<Arrival<v1::SessionNote>> notes;  ///< By the time of writing.

  std::vector<Arrival<v1::SessionCommand>> commands;  ///< Of operators, to this session.
  std::vector<Arrival<v1::SessionReply>> replies;
  std::vector<Arrival<v1::RigCommand>> rig_commands;
  std::vector<Arrival<v1::RigReply>> rig_replies;

  /// As descriptions: in force at the begin, and changes since.
  std::vector<Arrival<v1::ServiceConfiguration>> configurations;
  std::vector<Arrival<v1::ClockOffset>> clock_offsets;

  /// Messages that this program cannot decode (of another version of the contract): "topic: why", one each.
  std::vector<std::string> undecodable;

  /// Sums over all trials that have a record; a trial without samples adds nothing.
  [[nodiscard]] Certificate certificate() const;

  /// True where every trial with an outcome is certified and none is without outcome.
  [[nodiscard]] bool is_whole() const;
};

/// The verdict that holds, an operator's review included (contract::standing_verdict()); none: there is no
/// verdict. Whatever counts or lists verdicts asks here.
[[nodiscard]] std::optional<v1::TrialVerdict> standing_verdict(const SessionTrial& trial);

/// The attempt that a note speaks of; 0: of no trial.
[[nodiscard]] std::uint32_t attempt_of(const Session& session, const v1::SessionNote& note);

/// Why a trial does not count, one line: its verdict's reason, or that it has none; empty where it counts.
[[nodiscard]] std::string why_not_counted(const SessionTrial& trial);

/// Topics of what surrounds a session and was mostly said before it began: of each, what was in force then
/// belongs to the session.
inline constexpr std::array<std::string_view, 3> kSurroundingTopics{topics::kRigDescription.spec.name,
                                                                    topics::kServiceConfiguration.spec.name,
                                                                    topics::kClockOffset.spec.name};

/// Asks the store for the session's messages, for what was in force when it began, and for results that came
/// late, after the next session had begun; other sessions' messages are not read. kNotFound: the store has no
/// plan of this session. kDataLoss: a message is damaged.
[[nodiscard]] Result<Session> read_session(Store& store, const Id& session);

/// The session that find_session() finds, read.
[[nodiscard]] Result<Session> read_found_session(Store& store, std::string_view wanted);

/// Orders by posture, set and bias, instruction, method, model; otherwise the order stays.
void sort_by_condition(std::vector<v1::Estimate>& estimates);

/// Of each estimate_id the one published last, sort_by_condition().
[[nodiscard]] std::vector<v1::Estimate> newest_estimates(const Session& session);

}  // namespace tonus::store
