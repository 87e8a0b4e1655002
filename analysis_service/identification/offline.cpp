#include "analysis_service/identification/offline.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/identification/condition_book.hpp"
#include "analysis_service/identification/conversion.hpp"
#include "analysis_service/identification/wire.hpp"
#include "analysis_service/impedance/trial.hpp"

namespace tonus::identification {
namespace {

std::vector<Row> rows_of(const recording::Recording& record, const recording::Stretch& stretch) {
  std::vector<Row> rows;
  rows.reserve(stretch.last - stretch.first + 1);
  for (std::size_t i = stretch.first; i <= stretch.last; ++i) {
    Row row;
    row.raw = record.rows[i].raw;
    row.raw.acquisition_ns = recording::row_time_ns(record, i);
    if (!record.commanded.empty()) row.commanded = record.commanded[i];
    row.phase = i < stretch.onset ? Phase::kWaiting : Phase::kPerturbing;
    row.is_missing = record.rows[i].is_missing;
    rows.push_back(row);
  }
  return rows;
}

TrialReport report_of(const recording::Recording& record, const recording::PerturbationEvent& event,
                      const recording::Stretch& stretch, std::uint32_t index) {
  TrialReport report;
  TrialPlan& plan = report.plan;
  plan.session = id_of(record.participant.id + "/" + record.session);
  plan.attempt = static_cast<std::uint32_t>(event.trial);
  plan.kind = event.is_continuous() ? TrialKind::kRecording : TrialKind::kPerturbation;
  plan.posture = record.posture;
  plan.posture_index = index;
  plan.position = record.posture_position.value_or(Eigen::Vector2d::Zero());
  plan.shoulder = record.shoulder;
  plan.set = static_cast<std::int32_t>(event.set);
  plan.bias = {event.bias_N[0], event.bias_N[1]};
  report.range = {stretch.first, stretch.last};
  report.onset = stretch.onset;
  report.sample_rate = record.sampling_frequency;
  return report;
}

/// Why the perturbation cannot be used as it stands; empty: it can.
std::string defect_of(const recording::Recording& record, const recording::PerturbationEvent& event,
                      std::span<const Row> rows) {
  if (!event.is_valid) return event.reason.empty() ? "flagged invalid" : event.reason;
  const auto missing = std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.is_missing; });
  if (missing > 0) return fmt::format("gap: {} rows missing, allowed none", missing);
  const auto saturated = std::count_if(rows.begin(), rows.end(), [&](const Row& row) {
    return impedance::is_clipped({&row.raw, 1}, record.rig.force_saturation_V);
  });
  if (saturated > 0)
    return fmt::format("saturated: {} rows with the force sensor at its limit, allowed none", saturated);
  return {};
}

Result<void> identify_recording(const recording::Recording& record, std::uint32_t index,
                                const BookSettings& settings, std::vector<OfflineEstimate>& estimates) {
  if (auto good = validate(record.rig); !good) {
    return fail(good.error().code, recording::describe(record) + ": " + good.error().message);
  }
  ConditionBook book(settings);
  std::vector<LeftOut> left_out;
  for (const auto& event : record.events) {
    const recording::Stretch stretch = recording::stretch_of(record, event);
    const auto rows = rows_of(record, stretch);
    const TrialReport report = report_of(record, event, stretch, index);
    std::string why = defect_of(record, event, rows);
    if (why.empty()) {
      const auto trial = trial_from_rows(frame_of(report), record.rig, rows, stretch.onset - stretch.first);
      if (!trial) {
        why = trial.error().message;
      } else if (auto added = book.add_valid(report, *trial); !added) {
        why = added.error().message;
      }
    }
    if (why.empty()) continue;
    left_out.push_back({event.trial, why});
    book.add_invalid(report);
  }
  const RigUnits units{record.displacement_unit, record.force_unit};
  for (const Condition& condition : book.changed()) {
    for (const auto& estimate : book.identify(condition)) {
      estimates.push_back(
          {record.participant.id, record.session, record.run, left_out, to_wire(estimate, units)});
    }
  }
  return {};
}

}  // namespace

Result<std::vector<OfflineEstimate>> identify_recordings(std::span<const recording::Recording> recordings,
                                                         const std::vector<impedance::Options>& analyses) {
  std::vector<OfflineEstimate> estimates;
  BookSettings settings;
  settings.analyses = analyses;
  std::uint32_t index = 0;
  for (const auto& record : recordings) {
    if (auto done = identify_recording(record, index++, settings, estimates); !done) return done.error();
  }
  return estimates;
}

}  // namespace tonus::identification
