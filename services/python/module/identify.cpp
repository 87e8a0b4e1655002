#include "services/python/module/identify.hpp"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/identification/conversion.hpp"
#include "analysis_service/offline/offline_book.hpp"
#include "analysis_service/offline/results_json.hpp"
#include "services/core/json_text.hpp"
#include "services/recording/recording.hpp"

namespace tonus::python {
namespace {

using identification::OfflineBook;
using identification::OfflineEstimate;
using identification::TrialReport;

/// The trial's rows as a dataset of converted channels gives them.
std::vector<identification::Row> rows_of(const ArrayTrial& trial, const ArrayCondition& condition) {
  recording::Recording clock;
  clock.sampling_frequency = condition.rate;
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const std::size_t count = trial.force.size() / condition.axes;
  std::vector<identification::Row> rows(count);
  for (std::size_t i = 0; i < count; ++i) {
    identification::Row& row = rows[i];
    row.raw.acquisition_ns = recording::row_time_ns(clock, i);
    row.commanded = {kUnknown, kUnknown};
    row.phase = !trial.onset || static_cast<std::int64_t>(i) >= *trial.onset
                    ? identification::Phase::kPerturbing
                    : identification::Phase::kWaiting;
    for (unsigned axis = 0; axis < condition.axes; ++axis) {
      const double x = trial.displacement[i * condition.axes + axis];
      const double f = trial.force[i * condition.axes + axis];
      row.is_missing = row.is_missing || !std::isfinite(x) || !std::isfinite(f);
      row.raw.encoder_count[axis] = x;
      row.raw.force_V[axis] = f;
      if (!trial.commanded.empty()) row.commanded[axis] = trial.commanded[i * condition.axes + axis];
    }
    if (!trial.commanded.empty() && condition.axes == 1) row.commanded[1] = 0.0;
    if (row.is_missing) {
      row.raw.encoder_count = {};
      row.raw.force_V = {};
    }
  }
  return rows;
}

TrialReport report_of(const ArrayTrial& trial, const ArrayCondition& condition, std::size_t index) {
  TrialReport report;
  report.plan.session = id_of("arrays");
  report.plan.attempt = static_cast<std::uint32_t>(index + 1);
  report.plan.kind =
      trial.onset ? identification::TrialKind::kPerturbation : identification::TrialKind::kRecording;
  report.plan.posture = condition.posture;
  report.plan.set = 1;
  report.plan.bias = {condition.bias[0], condition.bias[1]};
  const std::size_t rows = trial.force.size() / condition.axes;
  report.range = {0, rows};
  report.onset = static_cast<std::uint64_t>(trial.onset.value_or(0));
  report.sample_rate = condition.rate;
  return report;
}

Result<void> check(const ArrayTrial& trial, const ArrayCondition& condition, std::size_t index) {
  const auto refuse = [&](const std::string& what) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("trial {}: {}", index + 1, what));
  };
  const std::size_t rows = trial.force.size() / condition.axes;
  const std::size_t others = trial.displacement.size() / condition.axes;
  if (rows != others)
    return refuse(
        fmt::format("displacement of {} rows is not allowed; expected {} as the force", others, rows));
  if (!trial.commanded.empty() && trial.commanded.size() != trial.force.size())
    return refuse(fmt::format("commanded of {} rows is not allowed; expected {} as the force",
                              trial.commanded.size() / condition.axes, rows));
  if (trial.onset && (*trial.onset < 1 || *trial.onset >= static_cast<std::int64_t>(rows)))
    return refuse(fmt::format("onset: row {} is not allowed; expected 1 to {}", *trial.onset,
                              static_cast<std::int64_t>(rows) - 1));
  return {};
}

void take(const ArrayTrial& trial, const ArrayCondition& condition, std::size_t index, OfflineBook& book) {
  const auto rows = rows_of(trial, condition);
  const TrialReport report = report_of(trial, condition, index);
  RigGeometry rig = recording::converted_rig(condition.axes == 1 ? RigKind::kOneAxis : RigKind::kCartesian);
  rig.handle_mass = condition.handle_mass;
  const auto onset = static_cast<std::size_t>(trial.onset.value_or(0));
  const auto converted = identification::trial_from_rows(identification::frame_of(report), rig, rows, onset);
  if (converted) {
    book.add(report, *converted);
  } else {
    book.leave_out(report, converted.error().message);
  }
}

}  // namespace

Result<std::vector<OfflineEstimate>> identify_arrays(const std::vector<ArrayTrial>& trials,
                                                     const ArrayCondition& condition,
                                                     const identification::Request& request) {
  if (!(condition.rate > 0.0) || !std::isfinite(condition.rate)) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("rate: {} Hz is not allowed; expected more than 0 Hz", condition.rate));
  }
  TONUS_TRY_ASSIGN(const auto analyses, identification::analyses_of(request));
  for (const auto& options : analyses) {
    TONUS_TRY(impedance::validate(options, 1.0 / condition.rate));
  }
  OfflineBook book(analyses, OfflineEstimate{});
  for (std::size_t i = 0; i < trials.size(); ++i) {
    TONUS_TRY(check(trials[i], condition, i));
    take(trials[i], condition, i, book);
  }
  return book.identify(condition.units, static_cast<int>(condition.axes));
}

std::string results_text(const std::vector<OfflineEstimate>& estimates) {
  return results_text(identification::DatasetEstimates{estimates, {}});
}

std::string results_text(const identification::DatasetEstimates& found) {
  nlohmann::json results = identification::json_of(found);
  results["axes"] = nlohmann::json::array();
  results["posture_m"] = nlohmann::json::array();
  for (const auto& estimate : found.estimates) {
    results["axes"].push_back(estimate.estimate.axes());
    results["posture_m"].push_back(estimate.estimate.posture_m());
  }
  return json_text(results, -1);
}

}  // namespace tonus::python
