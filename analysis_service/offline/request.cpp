#include "analysis_service/offline/request.hpp"

#include <iterator>

#include "analysis_service/offline/archived_session.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::identification {
namespace {

/// Refuses settings that the rate of the session's first samples does not allow.
Result<void> check_settings(const store::Session& session, const std::vector<impedance::Options>& analyses) {
  for (const auto& trial : session.trials) {
    if (!trial.outcome || !(trial.outcome->value.sample_rate_Hz() > 0.0)) continue;
    const double period = 1.0 / trial.outcome->value.sample_rate_Hz();
    for (const auto& options : analyses) {
      TONUS_TRY(impedance::validate(options, period));
    }
    return {};
  }
  return {};
}

}  // namespace

Result<std::vector<impedance::Options>> analyses_of(const Request& request) {
  std::vector<impedance::Options> methods = impedance::by_every_method(request.settings);
  if (request.method != "all") {
    auto method = impedance::with_method(request.settings, request.method);
    if (!method) return fail(method.error().code, "method: " + method.error().message);
    methods = {*method};
  }
  std::vector<impedance::Model> models(std::begin(impedance::kModels), std::end(impedance::kModels));
  if (request.model != "all") {
    auto model = impedance::model_named(request.model);
    if (!model) return fail(model.error().code, "model: " + model.error().message);
    models = {*model};
  }
  std::vector<impedance::Options> analyses;
  for (const auto& method : methods) {
    for (const auto model : models) {
      if (methods.size() > 1 && !impedance::has_model(method.method, model)) continue;
      analyses.push_back(method);
      analyses.back().model = model;
    }
  }
  return analyses;
}

Result<std::vector<OfflineEstimate>> identify_archived(store::Store& store, const std::string& wanted,
                                                       const std::vector<impedance::Options>& analyses,
                                                       const JudgeChoice& judge) {
  TONUS_TRY_ASSIGN(const auto session, store::read_found_session(store, wanted));
  TONUS_TRY(check_settings(session, analyses));
  return identify_session(store, session, analyses, judge);
}

}  // namespace tonus::identification
