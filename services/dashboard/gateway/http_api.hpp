#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "services/core/result.hpp"

/// What pages ask for by HTTP: protocols, past sessions, reports. Reads files and the archive; nothing is
/// written. Every call stands for itself, so that an archive which appears later is found.
namespace tonus::dashboard {

struct ApiAnswer {
  int status = 200;
  std::string type = "application/json";
  std::string body;
};

struct ApiFolders {
  std::string store;                ///< As `tonus-archive --store`.
  std::filesystem::path protocols;  ///< *.toml; empty: none.
  std::filesystem::path reports;    ///< Made by `tonus report`; may not exist.
  std::filesystem::path exports{};  ///< What jobs made (jobs.hpp); may not exist.
  std::filesystem::path tonus{};    ///< The program that jobs run; empty: there are no jobs.
};

/// GET of a path (without query; `topic` is the query's "topic"):
///
///     /api/protocols              [{"name", "text"}]
///     /api/sessions               [{"session_id", "subject", "protocol", "started_at", ...}], newest first
///     /api/sessions/ID            the same with "trials" and "certificate"
///     /api/subjects, /api/studies people_api.hpp
///     /api/sessions/ID/estimates, /verdicts, /outcomes, /plans, /reviews, /notes
///                                 messages in JSON (json_messages.hpp); time_ns: when the archive got them
///     /api/sessions/ID/messages   ?topic=session/plan, session/state, estimate/condition, trial/outcome,
///                                 trial/verdict, trial/review, session/note or rig/description: CDR messages
///                                 as the bus carries them, each after its length in bytes (uint32, little
///                                 endian)
///     /api/sessions/ID/courses/ATTEMPT
///                                 displacement and force about a trial's onset, and of the eight before it:
///                                 trial_course.hpp
///     /api/reports                [{"path", "bytes", "modified"}]
///     /reports/PATH               a file of the reports' folder
///
/// Anything else: 404. Errors: {"error": "..."} with 404 or 503.
[[nodiscard]] ApiAnswer answer_api(const ApiFolders& folders, std::string_view path, std::string_view topic);

}  // namespace tonus::dashboard
