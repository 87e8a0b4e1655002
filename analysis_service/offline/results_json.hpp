#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "analysis_service/offline/offline.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::identification {

/// `{"schema": 1, "conditions": [...]}`: one object for each estimate, services/contract/estimate_json.hpp,
/// with whose it is and what was left out. The JSON of `tonus identify`, `run` and `show`, and of Python.
[[nodiscard]] nlohmann::json json_of(const std::vector<OfflineEstimate>& estimates);

/// The same with `left_out`, a line for each item of a dataset that was left out, where there is one.
[[nodiscard]] nlohmann::json json_of(const DatasetEstimates& found);

/// The newest estimates that an archived session's services published, with the trials that were rejected.
[[nodiscard]] std::vector<OfflineEstimate> published_results(const store::Session& session);

}  // namespace tonus::identification
