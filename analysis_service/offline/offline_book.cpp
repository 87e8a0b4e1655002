#include "analysis_service/offline/offline_book.hpp"

#include <set>
#include <utility>

namespace tonus::identification {
namespace {

BookSettings settings_of(const std::vector<impedance::Options>& analyses) {
  BookSettings settings;
  settings.analyses = analyses;
  return settings;
}

}  // namespace

OfflineBook::OfflineBook(const std::vector<impedance::Options>& analyses, OfflineEstimate owner)
    : book_(settings_of(analyses)), owner_(std::move(owner)) {}

void OfflineBook::add(const TrialReport& report, const impedance::Trial& trial) {
  if (auto added = book_.add_valid(report, trial); !added) leave_out(report, added.error().message);
}

void OfflineBook::leave_out(const TrialReport& report, std::string why) {
  book_.add_invalid(report);
  const Condition condition = condition_of(report.plan);
  const Condition own_set = set_condition_of(report.plan);
  if (condition < own_set || own_set < condition) left_out_[own_set].push_back({report.plan.attempt, why});
  left_out_[condition].push_back({report.plan.attempt, std::move(why)});
}

std::vector<OfflineEstimate> OfflineBook::identify(const RigUnits& units, int axes) {
  std::set<Condition> conditions;
  for (const Condition& condition : book_.changed()) conditions.insert(condition);
  for (const auto& [condition, trials] : left_out_) {
    const bool is_single_unloaded_set = !condition.is_loaded() && condition.set != 0;
    if (!is_single_unloaded_set) conditions.insert(condition);
  }
  std::vector<OfflineEstimate> estimates;
  for (const Condition& condition : conditions) {
    const auto left_out = left_out_.find(condition);
    for (ConditionEstimate& found : book_.identify(condition)) {
      if (found.estimate.axes == 0) found.estimate.axes = axes;  // no trial told
      OfflineEstimate estimate = owner_;
      if (left_out != left_out_.end()) estimate.left_out = left_out->second;
      estimate.estimate = to_wire(found, units);
      estimates.push_back(std::move(estimate));
    }
  }
  return estimates;
}

}  // namespace tonus::identification
