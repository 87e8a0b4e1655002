#include "analysis_service/study/session_analysis.hpp"

#include <algorithm>
#include <map>

#include "analysis_service/impedance/reconstruction.hpp"
#include "analysis_service/offline/archived_trial.hpp"
#include "analysis_service/service/wire.hpp"

namespace tonus::study {
namespace {

using identification::Condition;

std::vector<impedance::Options> analyses() {
  std::vector<impedance::Options> all;
  for (const impedance::Method method : impedance::kPerturbationMethods) {
    impedance::Options options;
    options.method = method;
    options.has_trace = method == impedance::Method::kStateVariable;
    all.push_back(options);
  }
  for (const impedance::Model model : impedance::kModels) {
    if (model == impedance::Model::kLinear) continue;
    impedance::Options options;
    options.model = model;
    options.has_trace = false;
    all.push_back(options);
  }
  return all;
}

bool has_bias(const store::SessionTrial& trial) {
  const auto& bias = trial.outcome->value.program().bias_N();
  return bias[0] != 0.0 || bias[1] != 0.0;
}

bool counts(const store::SessionTrial& trial) {
  return trial.outcome && store::why_not_counted(trial).empty();
}

Result<impedance::Trial> trial_of(store::Store& store, const store::Session& session,
                                  const store::SessionTrial& trial) {
  TONUS_TRY_ASSIGN(const auto archived, identification::read_archived_trial(store, session, trial));
  return identification::convert(archived);
}

}  // namespace

const impedance::Estimate* ConditionAnalysis::find(impedance::Method method, impedance::Model model) const {
  const auto found =
      std::find_if(estimates.begin(), estimates.end(), [&](const impedance::Estimate& estimate) {
        return estimate.method == method && estimate.model == model &&
               estimate.status != impedance::Status::kUndetermined;
      });
  return found == estimates.end() ? nullptr : &*found;
}

std::optional<impedance::AxisVector> ConditionAnalysis::fitting_error(impedance::Model model) const {
  const auto* estimate = find(impedance::Method::kStateVariable, model);
  if (estimate == nullptr) return std::nullopt;
  const auto error = impedance::reconstruction_error(trials, *estimate, {});
  return error ? std::optional(*error) : std::nullopt;
}

impedance::StaticOptions static_options() {
  impedance::StaticOptions options;
  options.cutoff = 5.0;
  return options;
}

Result<std::map<Condition, std::vector<impedance::Trial>>> condition_trials(store::Store& store,
                                                                            const store::Session& session) {
  bool is_loaded = false;
  for (const auto& trial : session.trials) is_loaded |= trial.outcome && has_bias(trial);
  std::map<Condition, std::vector<impedance::Trial>> trials;
  for (const auto& trial : session.trials) {
    if (!counts(trial)) continue;
    TONUS_TRY_ASSIGN(auto prepared, trial_of(store, session, trial));
    const auto plan = identification::from_wire(trial.outcome->value).plan;
    trials[is_loaded ? set_condition_of(plan) : condition_of(plan)].push_back(std::move(prepared));
  }
  return trials;
}

Result<SessionAnalysis> analyse(store::Store& store, const store::Session& session) {
  SessionAnalysis analysis;
  analysis.session = session.record.session;
  analysis.subject = session.plan.subject();
  analysis.protocol = session.plan.protocol_name();
  analysis.software_version = session.plan.software_version();
  analysis.seed = session.plan.seed();
  analysis.is_simulated =
      !session.descriptions.empty() && std::ranges::all_of(session.descriptions, [](const auto& description) {
        return description.value.driver() == "simulated";
      });
  for (const auto& trial : session.trials) analysis.is_loaded |= trial.outcome && has_bias(trial);

  for (const auto& trial : session.trials) ++(counts(trial) ? analysis.trials : analysis.rejected);
  TONUS_TRY_ASSIGN(auto trials, condition_trials(store, session));
  for (auto& [condition, list] : trials) {
    ConditionAnalysis result{condition, std::move(list), {}};
    for (auto& estimate : impedance::identify_each(result.trials, analyses())) {
      if (!estimate) return estimate.error();
      result.estimates.push_back(std::move(*estimate));
    }
    analysis.conditions.push_back(std::move(result));
  }
  const auto order = [](const ConditionAnalysis& c) {
    return std::make_pair(c.condition.posture_index, c.condition.set);
  };
  std::sort(analysis.conditions.begin(), analysis.conditions.end(),
            [&](const auto& a, const auto& b) { return order(a) < order(b); });
  return analysis;
}

}  // namespace tonus::study
