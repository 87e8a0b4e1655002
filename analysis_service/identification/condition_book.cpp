#include "analysis_service/identification/condition_book.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/impedance/refined_identification.hpp"

namespace tonus::identification {
namespace {

/// Has a condition of its own set beside the one of all sets together.
bool has_own_set(const TrialPlan& plan) { return !plan.is_loaded() && plan.set != 0; }

}  // namespace

TrialSource source_of(const TrialReport& report) {
  return {report.plan.attempt, report.epoch, report.range, report.onset};
}

Result<void> ConditionBook::add_valid(const TrialReport& report, const impedance::Trial& trial) {
  const TrialPlan& plan = report.plan;
  const Condition condition = condition_of(plan);
  if (const auto page = pages_.find(condition); page != pages_.end()) {
    if (page->second.valid.contains(plan.attempt)) return {};
    if (page->second.valid.size() >= settings_.most_trials) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("trial {}: its condition has {} trials; expected at most {}", plan.attempt,
                              page->second.valid.size(), settings_.most_trials));
    }
  }
  insert(condition, report, trial);
  if (has_own_set(plan)) insert(set_condition_of(plan), report, trial);
  if (plan.is_loaded() && loaded_sessions_.insert(plan.session).second) show_sets_of(plan.session);
  return {};
}

void ConditionBook::insert(const Condition& condition, const TrialReport& report,
                           const impedance::Trial& trial) {
  Page& page = pages_[condition];
  page.valid.emplace(report.plan.attempt, Entry{source_of(report), trial});
  page.has_had_valid = true;
  page.axes = trial.axes();
  page.has_records |= trial.is_continuous;
  note_change(condition);
}

void ConditionBook::note_change(const Condition& condition) {
  const bool is_single_set = !condition.is_loaded() && condition.set != 0;
  if (!is_single_set || loaded_sessions_.contains(condition.session)) changed_.insert(condition);
}

void ConditionBook::add_invalid(const TrialReport& report) {
  pages_[condition_of(report.plan)].invalid.insert(report.plan.attempt);
  if (has_own_set(report.plan)) pages_[set_condition_of(report.plan)].invalid.insert(report.plan.attempt);
}

void ConditionBook::withdraw(const Id& session, std::uint32_t attempt) {
  for (auto& [condition, page] : pages_) {
    if (condition.session != session || page.valid.erase(attempt) == 0) continue;
    page.invalid.insert(attempt);
    note_change(condition);
  }
}

void ConditionBook::show_sets_of(const Id& session) {
  for (const auto& [condition, page] : pages_) {
    const bool is_hidden = condition.session == session && !condition.is_loaded() && condition.set != 0;
    if (is_hidden && page.has_had_valid) changed_.insert(condition);
  }
}

std::vector<ConditionEstimate> ConditionBook::identify(const Condition& condition) {
  changed_.erase(condition);
  std::vector<ConditionEstimate> estimates;
  const auto found = pages_.find(condition);
  if (found == pages_.end()) return estimates;
  const Page& page = found->second;

  std::vector<impedance::Trial> trials;
  trials.reserve(page.valid.size());
  for (const auto& [attempt, entry] : page.valid) trials.push_back(entry.trial);

  const std::vector<impedance::Options> all_analyses = analyses();
  auto all_identified = impedance::identify_each(trials, all_analyses);
  for (std::size_t i = 0; i < all_identified.size(); ++i) {
    const impedance::Options& options = all_analyses[i];
    const impedance::Method method = page.has_records ? options.record_method : options.method;
    // Of all methods, each has the data that it suits.
    if (!impedance::suits(method, page.has_records) && all_analyses.size() > 1) continue;
    auto& identified = all_identified[i];
    ConditionEstimate estimate;
    estimate.condition = found->first;
    estimate.options = options;
    estimate.invalid_trials = static_cast<std::uint32_t>(page.invalid.size());
    if (identified) {
      estimate.estimate = std::move(*identified);
      if (is_precision_led_) impedance::widen_by_process(trials, options, estimate.estimate);
      if (trials.empty()) {  // nobody could tell what there was
        estimate.estimate.method = method;
        estimate.estimate.axes = page.axes;
      }
    } else {
      estimate.estimate.method = method;
      estimate.estimate.model = options.model;
      estimate.refusal = identified.error().message;
    }
    for (const std::uint32_t attempt : estimate.estimate.trials_used) {
      if (const auto entry = page.valid.find(attempt); entry != page.valid.end()) {
        estimate.trials.push_back(entry->second.source);
      }
    }
    estimates.push_back(std::move(estimate));
  }
  return estimates;
}

std::vector<impedance::Options> ConditionBook::analyses() const {
  std::vector<impedance::Options> all = settings_.analyses;
  for (const impedance::Options& further : further_) {
    const bool is_there = std::any_of(all.begin(), all.end(), [&](const impedance::Options& other) {
      return other.method == further.method && other.model == further.model;
    });
    if (!is_there) all.push_back(further);
  }
  return all;
}

std::vector<TrialSource> ConditionBook::sources(const Condition& condition) const {
  std::vector<TrialSource> all;
  const auto page = pages_.find(condition);
  if (page == pages_.end()) return all;
  for (const auto& [attempt, entry] : page->second.valid) all.push_back(entry.source);
  return all;
}

void ConditionBook::keep_only(const Id& session) {
  std::erase_if(pages_, [&](const auto& page) { return page.first.session != session; });
  std::erase_if(changed_, [&](const auto& condition) { return condition.session != session; });
  std::erase_if(loaded_sessions_, [&](const auto& loaded) { return loaded != session; });
}

}  // namespace tonus::identification
