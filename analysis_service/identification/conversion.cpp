#include "analysis_service/identification/conversion.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/identification/trial_section.hpp"

namespace tonus::identification {

TarePolicy tare_of(const TrialPlan& plan) {
  return plan.is_loaded() ? TarePolicy::kDescriptionOffset : TarePolicy::kRestBeforeOnset;
}

TrialFrame frame_of(const TrialReport& report) {
  TrialFrame frame;
  frame.number = report.plan.attempt;
  frame.kind = report.plan.kind;
  frame.shoulder = report.plan.shoulder;
  frame.tare = tare_of(report.plan);
  frame.sample_rate = report.sample_rate;
  return frame;
}

int axes_of(const RigGeometry& rig) { return rig.kind == RigKind::kOneAxis ? 1 : 2; }

impedance::Preparation preparation_of(const TrialFrame& frame, const RigGeometry& rig) {
  impedance::Preparation preparation;
  preparation.axes = axes_of(rig);
  preparation.sample_period = 1.0 / frame.sample_rate;
  preparation.rest = frame.rest;
  preparation.is_force_tared = frame.tare == TarePolicy::kRestBeforeOnset;
  preparation.handle_mass = rig.handle_mass;
  return preparation;
}

std::vector<EndpointSample> convert(const RigGeometry& rig, const ShoulderPose& shoulder,
                                    std::span<const Row> rows) {
  std::vector<EndpointSample> samples;
  samples.reserve(rows.size());
  for (const Row& row : rows) samples.push_back(tonus::convert(rig, shoulder, row.raw));
  return samples;
}

Result<impedance::Trial> trial_from_rows(const TrialFrame& frame, const RigGeometry& rig,
                                         std::span<const Row> rows, std::size_t onset) {
  if (!(frame.sample_rate > 0.0)) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("trial {}: sample rate {} Hz is not allowed; expected more than 0 Hz",
                            frame.number, frame.sample_rate));
  }
  Section used{0, rows.size()};
  if (frame.kind == TrialKind::kPerturbation) {
    used = {rest_before(rows, onset, rows_of(frame.rest, frame.sample_rate)).first,
            perturbation_from(rows, onset).end};
  }
  rows = rows.subspan(used.first, used.rows());
  const auto missing = std::find_if(rows.begin(), rows.end(), [](const Row& row) { return row.is_missing; });
  const bool is_any_there =
      std::any_of(rows.begin(), rows.end(), [](const Row& row) { return !row.is_missing; });
  if (missing != rows.end() && (frame.kind == TrialKind::kPerturbation || !is_any_there)) {
    return fail(ErrorCode::kDataLoss,
                fmt::format("trial {}: row {} is missing; expected every row", frame.number,
                            used.first + static_cast<std::size_t>(missing - rows.begin())));
  }
  std::vector<Eigen::Vector2d> commanded;
  commanded.reserve(rows.size());
  for (const Row& row : rows) commanded.emplace_back(row.commanded[0], row.commanded[1]);
  const bool is_known = std::all_of(rows.begin(), rows.end(), [](const Row& row) {
    return row.is_missing || (std::isfinite(row.commanded[0]) && std::isfinite(row.commanded[1]));
  });
  if (!is_known) commanded.clear();

  const auto samples = convert(rig, frame.shoulder, rows);
  const auto preparation = preparation_of(frame, rig);
  std::vector<bool> is_missing;
  for (const Row& row : rows) is_missing.push_back(row.is_missing);
  auto trial =
      frame.kind == TrialKind::kRecording
          ? impedance::prepare_record(frame.number, samples, preparation, commanded, std::move(is_missing))
          : impedance::prepare_trial(frame.number, samples, static_cast<Eigen::Index>(onset - used.first),
                                     preparation, commanded);
  if (!trial) return trial;
  trial->is_clipped = std::any_of(rows.begin(), rows.end(), [&](const Row& row) {
    return !row.is_missing &&
           (row.is_saturated || impedance::is_clipped({&row.raw, 1}, rig.force_saturation_V));
  });
  return trial;
}

}  // namespace tonus::identification
