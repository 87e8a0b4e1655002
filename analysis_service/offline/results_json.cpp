#include "analysis_service/offline/results_json.hpp"

#include <nlohmann/json.hpp>

#include "services/contract/estimate_json.hpp"

namespace tonus::identification {
namespace {

using nlohmann::json;

json condition(const OfflineEstimate& result) {
  json rejected = json::array();
  for (const auto& trial : result.left_out)
    rejected.push_back({{"trial", trial.trial}, {"reason", trial.reason}});
  json object = contract::json_of(result.estimate);
  object.update({{"participant", result.participant},
                 {"session", result.session.empty() ? json(nullptr) : json(result.session)},
                 {"run", result.run},
                 {"trials_rejected", rejected}});
  if (!result.tracking_system.empty()) object["tracking_system"] = result.tracking_system;
  return object;
}

}  // namespace

json json_of(const std::vector<OfflineEstimate>& estimates) {
  json conditions = json::array();
  for (const auto& estimate : estimates) conditions.push_back(condition(estimate));
  return {{"schema", 1}, {"conditions", conditions}};
}

json json_of(const DatasetEstimates& found) {
  json object = json_of(found.estimates);
  if (!found.left_out.empty()) object["left_out"] = found.left_out;
  return object;
}

std::vector<OfflineEstimate> published_results(const store::Session& session) {
  std::vector<OfflineEstimate> results;
  for (const auto& estimate : store::newest_estimates(session)) {
    OfflineEstimate result{session.record.subject,
                           to_hex(session.record.session),
                           static_cast<int>(estimate.posture_index()) + 1,
                           {},
                           {},
                           estimate};
    for (const auto& trial : session.trials) {
      const auto verdict = store::standing_verdict(trial);
      if (!verdict || verdict->is_valid()) continue;
      if (verdict->posture_index() == estimate.posture_index())
        result.left_out.push_back({trial.attempt, verdict->detail()});
    }
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace tonus::identification
