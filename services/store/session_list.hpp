#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"
#include "services/store/store.hpp"

#include <idl/session.h>

/// What an archive says of its sessions, subjects and studies without any trial being read.
namespace tonus::store {

/// A session's plan and newest state.
struct SessionSummary {
  SessionRecord record;
  v1::SessionPlan plan;                   ///< The newest; as the record where none can be decoded.
  std::optional<v1::SessionState> state;  ///< None before the scheduler's first one.

  [[nodiscard]] bool is_completed() const;
};

/// All sessions by start. Damaged plans and states are left out; other errors are the store's.
[[nodiscard]] Result<std::vector<SessionSummary>> summarise_sessions(Store& store);

/// A person who was measured.
struct KnownSubject {
  std::string subject;
  v1::SubjectFacts facts;          ///< Of each fact the newest that is known.
  std::size_t sessions = 0;        ///< All, pilots too.
  std::size_t pilot_sessions = 0;  ///< Of those.
  SessionRecord last;              ///< The session that began last.
};

/// By subject.
[[nodiscard]] std::vector<KnownSubject> subjects_of(const std::vector<SessionSummary>& sessions);
[[nodiscard]] Result<std::vector<KnownSubject>> list_subjects(Store& store);

/// A session that belongs to a study.
struct StudySession {
  Id session{};
  std::string protocol_name;
  std::string started_at;                 ///< ISO 8601, UTC.
  std::optional<v1::SessionPhase> phase;  ///< None: no state is archived.
  std::uint32_t counted = 0;
  std::uint32_t planned = 0;
  bool is_pilot = false;

  /// It counts as one of the study's: completed, and no pilot.
  [[nodiscard]] bool is_done() const;
};

/// What a subject has done in a study.
struct StudySubjectProgress {
  std::string subject;
  std::vector<StudySession> sessions;  ///< By start.

  /// Whether a session of this protocol is done.
  [[nodiscard]] bool has_done(std::string_view protocol_name) const;
  [[nodiscard]] std::size_t done() const;
};

/// Of the study of this name, by subject. A session belongs to the study that its plan names.
[[nodiscard]] std::vector<StudySubjectProgress> progress_of(const std::vector<SessionSummary>& sessions,
                                                            std::string_view study);
[[nodiscard]] Result<std::vector<StudySubjectProgress>> study_progress(Store& store, std::string_view study);

/// Names of the studies that sessions belong to, sorted.
[[nodiscard]] std::vector<std::string> studies_of(const std::vector<SessionSummary>& sessions);

}  // namespace tonus::store
