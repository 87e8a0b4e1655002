#include "analysis_service/offline/offline.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/identification/conversion.hpp"
#include "analysis_service/impedance/trial.hpp"
#include "analysis_service/offline/offline_book.hpp"
#include "analysis_service/service/wire.hpp"
#include "services/core/parallel.hpp"

namespace tonus::identification {
namespace {

std::vector<Row> rows_of(const recording::Recording& record, const recording::Stretch& stretch) {
  std::vector<Row> rows;
  rows.reserve(stretch.last - stretch.first + 1);
  for (std::size_t i = stretch.first; i <= stretch.last; ++i) {
    Row row;
    row.raw = record.rows[i].raw;
    row.raw.acquisition_ns = recording::row_time_ns(record, i);
    row.commanded = record.commanded.empty() ? recording::kNoCommand : record.commanded[i];
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
  plan.is_place_known = record.posture_position.has_value();
  plan.shoulder = record.shoulder;
  plan.set = static_cast<std::int32_t>(event.set);
  plan.instruction = event.instruction;
  plan.bias = {event.bias_N[0], event.bias_N[1]};
  plan.bias_hold = event.bias_hold_s.value_or(0.0);
  plan.bias_threshold = event.bias_threshold_N.value_or(0.0);
  report.range = SequenceRange::from_first_to_last(stretch.first, stretch.last);
  report.onset = stretch.onset;
  report.sample_rate = record.sampling_frequency;
  return report;
}

/// The offset of converted force channels is not known: their force at rest says nothing unless a limit was
/// chosen for it.
JudgeLimits limits_for(const recording::Recording& record, const JudgeChoice& choice, const RigUnits& units) {
  JudgeLimits limits = choice.limits(is_rotary(units));
  if (!record.is_raw && !choice.rest_force) limits.rest_force = std::numeric_limits<double>::infinity();
  return limits;
}

/// Why the trial does not count; empty: it does.
std::string defect_of(const recording::PerturbationEvent& event, const MeasuredTrial& trial,
                      const RigGeometry& rig, const TrialJudge& judge) {
  if (!event.is_valid) return event.reason.empty() ? "flagged invalid" : event.reason;
  const Verdict verdict = judge.judge(trial, &rig);
  return verdict.is_valid ? std::string{} : verdict.detail;
}

/// Every analysis of one recording, the `index`th of its dataset.
Result<std::vector<OfflineEstimate>> identify_recording(const recording::Recording& record, std::size_t index,
                                                        const std::vector<impedance::Options>& analyses,
                                                        const JudgeChoice& choice) {
  if (auto good = validate(record.rig); !good)
    return fail(good.error().code, recording::describe(record) + ": " + good.error().message);
  OfflineEstimate owner;
  owner.participant = record.participant.id;
  owner.session = record.session;
  owner.run = record.run;
  owner.tracking_system = record.tracking_system;
  OfflineBook book(analyses, std::move(owner));
  const RigUnits units{record.displacement_unit, record.force_unit};
  const TrialJudge judge(limits_for(record, choice, units));
  std::size_t unused = 0;  // first row that no continuous event has yet
  for (const auto& event : record.events) {
    const recording::Stretch stretch = recording::stretch_of(record, event);
    const TrialReport report = report_of(record, event, stretch, static_cast<std::uint32_t>(index));
    const MeasuredTrial trial{report, rows_of(record, stretch), {}, 0, 0};
    auto why = defect_of(event, trial, record.rig, judge);
    if (why.empty() && event.is_continuous()) {
      if (stretch.first < unused)
        why = fmt::format("overlap: its rows begin {} rows before the end of the event before it, allowed 0",
                          unused - stretch.first);
      else
        unused = stretch.last + 1;
    }
    if (!why.empty()) {
      book.leave_out(report, std::move(why));
      continue;
    }
    const auto converted =
        trial_from_rows(frame_of(report), record.rig, trial.rows, stretch.onset - stretch.first);
    if (converted) {
      book.add(report, *converted);
    } else {
      book.leave_out(report, converted.error().message);
    }
  }
  return book.identify(units, axes_of(record.rig));
}

using Estimates = Result<std::vector<OfflineEstimate>>;

/// identify(i) for every i, on all processors, in order.
template <typename Identify>
std::vector<Estimates> identify_each(std::size_t count, const Identify& identify) {
  std::vector<std::optional<Estimates>> found(count);
  for_each_in_parallel(count, [&](std::size_t i) { found[i] = identify(i); });
  std::vector<Estimates> all;
  all.reserve(count);
  for (auto& of_one : found) all.push_back(*std::move(of_one));
  return all;
}

void append(std::vector<OfflineEstimate> part, std::vector<OfflineEstimate>& all) {
  std::move(part.begin(), part.end(), std::back_inserter(all));
}

}  // namespace

Result<std::vector<OfflineEstimate>> identify_recordings(std::span<const recording::Recording> recordings,
                                                         const std::vector<impedance::Options>& analyses,
                                                         const JudgeChoice& judge) {
  std::vector<OfflineEstimate> all;
  for (auto& of_one : identify_each(recordings.size(), [&](std::size_t i) {
         return identify_recording(recordings[i], i, analyses, judge);
       })) {
    if (!of_one) return of_one.error();
    append(*std::move(of_one), all);
  }
  return all;
}

Result<DatasetEstimates> identify_dataset(const recording::Dataset& dataset,
                                          const std::vector<impedance::Options>& analyses,
                                          std::optional<int> force_sign, const JudgeChoice& judge) {
  auto runs = identify_each(dataset.runs(), [&](std::size_t i) -> Estimates {
    TONUS_TRY_ASSIGN(auto record, dataset.read(i));
    for (const auto& options : analyses) {
      TONUS_TRY(impedance::validate(options, 1.0 / record.sampling_frequency));
    }
    if (force_sign) {
      TONUS_TRY(recording::state_force_sign(record, *force_sign));
    }
    return identify_recording(record, i, analyses, judge);
  });
  DatasetEstimates found{{}, dataset.left_out()};
  std::optional<Error> first;
  for (auto& run : runs) {
    if (run) {
      append(*std::move(run), found.estimates);
      continue;
    }
    if (!first) first = run.error();
    found.left_out.push_back(run.error().message);
  }
  const bool has_none = std::ranges::none_of(runs, [](const Estimates& run) { return run.has_value(); });
  if (first && has_none) return *first;
  return found;
}

}  // namespace tonus::identification
