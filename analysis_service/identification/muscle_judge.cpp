#include "analysis_service/identification/muscle_judge.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include "analysis_service/identification/trial_section.hpp"

namespace tonus::identification {

void MuscleJudge::begin(muscles::MuscleSettings settings) {
  settings_ = std::move(settings);
  reference_.clear();
}

void MuscleJudge::judge(const MeasuredTrial& trial, const JudgeLimits& limits, Verdict& verdict) {
  const TrialReport& report = trial.report;
  if (trial.auxiliary.empty() || report.end != TrialEnd::kCompleted) return;
  if (report.plan.kind == TrialKind::kContraction) {
    if (verdict.is_valid) reference_.add(report.plan.trial, trial.auxiliary);
    return;
  }
  if (report.plan.kind != TrialKind::kPerturbation || !report.range.contains(report.onset)) return;
  const auto onset = static_cast<std::size_t>(report.onset - report.range.first);
  const Section rest = rest_before(trial.rows, onset, rows_of(limits.rest, report.sample_rate));
  const auto time_of = [&](std::size_t row) { return static_cast<double>(row) / report.sample_rate; };
  verdict.activity = reference_.measure(trial.auxiliary, {time_of(rest.first), time_of(rest.end)},
                                        time_of(onset), settings_);
  const auto active = verdict.activity.above(settings_.most_activity);
  if (active.empty()) return;
  const std::string text =
      fmt::format("{}: {} of the reference contraction before the onset, allowed {:.3f}",
                  name_of(Defect::kMusclesActive), fmt::join(active, ", "), settings_.most_activity);
  verdict.detail = verdict.is_valid ? text : verdict.detail + "; " + text;
  verdict.is_valid = false;
  verdict.defects.push_back(Defect::kMusclesActive);
}

}  // namespace tonus::identification
