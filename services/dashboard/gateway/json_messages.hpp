#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/bus/bus.hpp"
#include "services/core/result.hpp"

/// The topics that the gateway also speaks in JSON, for browsers, MATLAB, R and Python: no CDR is needed.
/// services/dashboard/openapi.json describes them.
namespace tonus::dashboard {

/// estimate/condition, estimate/live, trial/verdict, trial/outcome, trial/review, session/plan,
/// session/state, session/note, rig/state, rig/description.
[[nodiscard]] std::span<const std::string_view> json_topics();

/// `{"topic": "...", "time_ns": ..., "message": {...}}`, the message as services/contract/message_json.hpp
/// has it. `time_ns`: when it was written, UTC. kInvalidArgument: another topic, or not a message of it.
[[nodiscard]] Result<std::string> json_message(std::string_view topic, std::uint64_t time_ns,
                                               std::span<const std::byte> payload);

/// The same of a message that is JSON already.
[[nodiscard]] std::string json_text_of(std::string_view topic, std::uint64_t time_ns, nlohmann::json message);

/// The topics of a query's "topics", "estimate/condition,trial/verdict"; empty: all of json_topics().
/// kInvalidArgument names one that does not exist and those that do.
[[nodiscard]] Result<std::vector<std::string_view>> json_topics_of(std::string_view query);

/// What a path of the HTTP interface gives out of what is in force: /api/estimates, /api/verdicts,
/// /api/outcomes, /api/reviews, /api/plans, /api/states, /api/notes, /api/rigs. None for any other path.
[[nodiscard]] std::vector<std::string_view> topics_of_path(std::string_view path);

/// "[a,b,...]" of JSON texts.
[[nodiscard]] std::string json_list(const std::vector<std::string>& texts);

}  // namespace tonus::dashboard
