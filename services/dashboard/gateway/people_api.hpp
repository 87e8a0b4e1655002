#pragma once

#include <filesystem>
#include <string>

#include "services/core/result.hpp"
#include "services/store/session_list.hpp"

/// What pages ask about subjects and studies, as JSON. Which sessions belong to a study, and which of them
/// count, is decided in services/store/session_list.hpp.
namespace tonus::dashboard {

/// [{"subject", "sessions", "pilot_sessions", "last_session_id", "last_started_at", "subject_facts"}], by
/// subject; facts as in services/contract/subject_json.hpp, of each the newest that is known.
[[nodiscard]] std::string subjects_json(const std::vector<store::SessionSummary>& sessions);

/// Every study among the protocols of the folder, and every other one that a session names:
///
///     [{"study", "file", "problem", "subjects": [{"subject", "seed", "done", "due",
///       "sessions": [{"protocol", "file", "is_done", "session_id", "state", "counted", "planned"}],
///       "others": [{the same, with "is_pilot"}]}],
///      "next": {"subject", "protocol", "file", "seed"} or null}]
///
/// "sessions" are those that the study plans, in its order; of each the session that is done, or the newest
/// one: "session_id" and "state" are null where there is none. "others" are further sessions of the subject
/// in this study, pilots too. "next" is the first planned session that is not done, of the subject who has
/// begun and is not done if there is one, else of the first one in the study's order.
[[nodiscard]] std::string studies_json(const std::vector<store::SessionSummary>& sessions,
                                       const std::filesystem::path& protocols);

}  // namespace tonus::dashboard
