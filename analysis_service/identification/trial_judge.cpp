#include "analysis_service/identification/trial_judge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/identification/conversion.hpp"
#include "analysis_service/identification/motion.hpp"
#include "analysis_service/identification/trial_section.hpp"

namespace tonus::identification {
namespace {

using Points = std::vector<Eigen::Vector2d>;

constexpr double kMillimetres = 1e3;
/// Of the hold asked for; the rest is the rounding of two clocks to whole rows.
constexpr double kLeastHoldShare = 0.95;

std::span<const Eigen::Vector2d> part(const Points& points, const Section& section) {
  return std::span(points).subspan(section.first, section.rows());
}

bool is_finite(const Row& row) {
  return std::isfinite(row.raw.encoder_count[0]) && std::isfinite(row.raw.encoder_count[1]) &&
         std::isfinite(row.raw.force_V[0]) && std::isfinite(row.raw.force_V[1]);
}

bool is_saturated(const Row& row, const RigGeometry* rig) {
  if (row.is_saturated) return true;
  return rig != nullptr && impedance::is_clipped({&row.raw, 1}, rig->force_saturation_V);
}

/// Rows that are marked as missing, or that the acquisition stamps show to be missing. Stamps that are all
/// equal are none.
std::uint64_t missing_rows(std::span<const Row> rows, double sample_rate) {
  auto missing = static_cast<std::uint64_t>(std::count_if(
      rows.begin(), rows.end(), [](const Row& row) { return row.is_missing || !is_finite(row); }));
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].is_missing || rows[i - 1].is_missing) continue;
    const auto step_ns = rows[i].raw.acquisition_ns - rows[i - 1].raw.acquisition_ns;
    const double periods = std::round(1e-9 * static_cast<double>(step_ns) * sample_rate);
    if (periods > 1.0) missing += static_cast<std::uint64_t>(periods) - 1;
  }
  return missing;
}

/// Collects defects with what is to be said of them.
class Findings {
 public:
  void add(Defect defect, const std::string& text) {
    defects_.push_back(defect);
    detail_ += fmt::format("{}{}: {}", detail_.empty() ? "" : "; ", name_of(defect), text);
  }
  void add_if(bool is_so, Defect defect, const std::string& text) {
    if (is_so) add(defect, text);
  }

  [[nodiscard]] Verdict verdict(const Measured& measured, std::string detail_if_valid) && {
    std::sort(defects_.begin(), defects_.end());
    defects_.erase(std::unique(defects_.begin(), defects_.end()), defects_.end());
    const bool is_valid = defects_.empty();
    return {is_valid,
            std::move(defects_),
            is_valid ? std::move(detail_if_valid) : std::move(detail_),
            measured,
            {}};
  }

 private:
  std::vector<Defect> defects_;
  std::string detail_;
};

std::string_view name_of(TrialEnd end) {
  switch (end) {
    case TrialEnd::kCompleted:
      return "completed";
    case TrialEnd::kAborted:
      return "aborted";
    case TrialEnd::kFaulted:
      return "stopped by a safety limit";
    case TrialEnd::kNotCentred:
      return "not centred";
    case TrialEnd::kBiasNotReached:
      return "bias not reached";
    case TrialEnd::kRefused:
      return "refused";
    case TrialEnd::kBrokenOff:
      return "broken off";
  }
  return "ended unknown";
}

/// A trial in SI with its parts: where the hand was and what it felt.
struct Traces {
  Points position;
  Points force;
  Section rest;
  Section hold;  // of the bias force
  bool is_hold_timed = false;
  Section perturbation;
  Section way_back;  // up to the last row; empty in recordings
};

Traces traces_of(const MeasuredTrial& trial, std::size_t onset, const RigGeometry& rig,
                 const JudgeLimits& limits) {
  const TrialPlan& plan = trial.report.plan;
  const double rate = trial.report.sample_rate;
  Traces traces;
  for (const EndpointSample& sample : convert(rig, plan.shoulder, trial.rows)) {
    traces.position.push_back(sample.p_SE);
    traces.force.push_back(sample.f_S);
    if (axes_of(rig) == 1) traces.position.back()[1] = traces.force.back()[1] = 0.0;
  }
  traces.rest = rest_before(trial.rows, onset, rows_of(limits.rest, rate));
  traces.hold = bias_hold_before(trial.rows, onset, rows_of(plan.bias_hold, rate));
  traces.is_hold_timed = std::any_of(trial.rows.begin(), trial.rows.end(), [](const Row& row) {
    return row.phase == Phase::kBiasRamp || row.phase == Phase::kBiasHold;
  });
  if (!traces.is_hold_timed) traces.hold = traces.rest;  // a recording knows no phases of the bias
  traces.perturbation = perturbation_from(trial.rows, onset);
  traces.way_back = {traces.perturbation.end, trial.rows.size()};
  return traces;
}

/// Measured::resistance.
double resistance(const Traces& traces, const TrialReport& report, const JudgeLimits& limits) {
  const std::size_t rows = rows_of(limits.speed_window, report.sample_rate, 2);
  const auto last_force = [&](const Section& section) {
    const auto force = part(traces.force, section);
    return mean(force.last(std::min(rows, force.size()))).norm();
  };
  if (report.plan.is_loaded()) {
    const bool has_way_back = traces.way_back.rows() >= 2 * rows;
    return has_way_back ? last_force(traces.way_back) : std::numeric_limits<double>::infinity();
  }
  const auto moved = part(traces.position, traces.perturbation);
  const auto end = mean(moved.last(std::min(rows, moved.size())));
  const bool is_displaced =
      (end - mean(part(traces.position, traces.rest))).norm() >= limits.resisted_displacement;
  return is_displaced ? last_force(traces.perturbation) : std::numeric_limits<double>::infinity();
}

void measure(const Traces& traces, const TrialReport& report, const JudgeLimits& limits, int axes,
             Measured& out) {
  const double period = 1.0 / report.sample_rate;
  const std::size_t window = rows_of(limits.speed_window, report.sample_rate, 2);
  Eigen::Vector2d place = report.plan.position;
  Eigen::Vector2d bias = report.plan.bias;
  if (axes == 1) place[1] = bias[1] = 0.0;
  // No hand is in its own shoulder: a plan without a place has zeros.
  const bool is_place_known = report.plan.is_place_known && (axes == 1 || !place.isZero(0.0));

  const auto rest = part(traces.position, traces.rest);
  const auto rest_force = part(traces.force, traces.rest);
  out.start_offset = is_place_known ? (mean(rest) - place).norm() : std::numeric_limits<double>::quiet_NaN();
  out.rest_speed = largest_speed(rest, window, period);
  out.rest_force = (mean(rest_force) - bias).norm();
  out.rest_force_change = mean_distances(rest_force, window, mean(rest_force)).largest;

  const auto bias_range = mean_distances(part(traces.force, traces.hold), window, bias);
  out.bias_nearest = bias_range.smallest;
  out.bias_error = bias_range.largest;
  out.bias_held = period * static_cast<double>(traces.hold.rows());

  const auto moved = part(traces.position, traces.perturbation);
  out.excursion = mean_distances(moved, 1, mean(rest)).largest;
  const std::size_t end_rows = std::min(rows_of(limits.end, report.sample_rate, 2), moved.size());
  out.end_speed = largest_speed(moved.last(end_rows), window, period);
  if (axes == 2) out.resistance = resistance(traces, report, limits);
}

void judge_bias(const TrialPlan& plan, bool is_hold_timed, const Measured& measured,
                const JudgeLimits& limits, Findings& findings) {
  const double stated = plan.bias_threshold > 0.0 ? plan.bias_threshold : limits.bias_threshold;
  const double threshold = stated * limits.bias_tolerance;
  const bool has_hold = measured.bias_held > 0.0;
  if (!has_hold || measured.bias_nearest > threshold) {
    findings.add(Defect::kBiasNotReached,
                 has_hold ? fmt::format("force at least {:.3f} N from the bias, allowed {:.3f} N",
                                        measured.bias_nearest, threshold)
                          : std::string("no hold before the onset"));
    return;
  }
  findings.add_if(
      measured.bias_error > threshold, Defect::kBiasNotHeld,
      fmt::format("force up to {:.3f} N from the bias, allowed {:.3f} N", measured.bias_error, threshold));
  findings.add_if(is_hold_timed && measured.bias_held < kLeastHoldShare * plan.bias_hold,
                  Defect::kBiasNotHeld,
                  fmt::format("held for {:.2f} s, needed {:.2f} s", measured.bias_held, plan.bias_hold));
}

void judge_motion(const TrialPlan& plan, bool is_hold_timed, const Measured& m, const JudgeLimits& limits,
                  Findings& findings) {
  findings.add_if(m.start_offset > limits.start_offset, Defect::kOffTarget,
                  fmt::format("hand {:.1f} mm from its place, allowed {:.1f} mm",
                              kMillimetres * m.start_offset, kMillimetres * limits.start_offset));
  if (plan.is_loaded()) judge_bias(plan, is_hold_timed, m, limits, findings);
  findings.add_if(m.rest_speed > limits.rest_speed, Defect::kEarlyReaction,
                  fmt::format("{:.1f} mm/s before the onset, allowed {:.1f} mm/s",
                              kMillimetres * m.rest_speed, kMillimetres * limits.rest_speed));
  findings.add_if(
      !plan.is_loaded() && m.rest_force > limits.rest_force, Defect::kEarlyReaction,
      fmt::format("{:.2f} N before the onset, allowed {:.2f} N", m.rest_force, limits.rest_force));
  findings.add_if(!plan.is_loaded() && m.rest_force_change > limits.rest_force_change, Defect::kEarlyReaction,
                  fmt::format("force changed by {:.2f} N before the onset, allowed {:.2f} N",
                              m.rest_force_change, limits.rest_force_change));
  findings.add_if(m.excursion > limits.excursion, Defect::kExcursion,
                  fmt::format("hand moved {:.1f} mm, allowed {:.1f} mm", kMillimetres * m.excursion,
                              kMillimetres * limits.excursion));
  findings.add_if(
      m.resistance < limits.resistance, Defect::kLetGo,
      fmt::format("the hand pushed with {:.2f} N {}, expected at least {:.2f} N", m.resistance,
                  plan.is_loaded() ? "after the perturbation" : "when displaced", limits.resistance));
  findings.add_if(m.end_speed > limits.end_speed, Defect::kNotAtRest,
                  fmt::format("{:.1f} mm/s at the end, allowed {:.1f} mm/s", kMillimetres * m.end_speed,
                              kMillimetres * limits.end_speed));
}

std::string summary(const Measured& m, const JudgeLimits& limits, bool is_loaded) {
  const std::string start = std::isfinite(m.start_offset)
                                ? fmt::format("start {:.1f} mm (limit {:.1f})", kMillimetres * m.start_offset,
                                              kMillimetres * limits.start_offset)
                                : "place not known";
  // Loaded, the force has the bias' threshold, which is held against another stretch.
  const std::string force_limit = is_loaded ? "" : fmt::format(" ({:.2f})", limits.rest_force);
  return fmt::format(
      "valid: {}, rest {:.1f} mm/s ({:.1f}) and {:.2f} N{}, moved {:.1f} mm "
      "({:.1f}), "
      "end {:.1f} mm/s ({:.1f})",
      start, kMillimetres * m.rest_speed, kMillimetres * limits.rest_speed, m.rest_force, force_limit,
      kMillimetres * m.excursion, kMillimetres * limits.excursion, kMillimetres * m.end_speed,
      kMillimetres * limits.end_speed);
}

/// Largest distance between two positions of an axis; 0: none is known.
double range_of(std::span<const Row> rows, const RigGeometry& rig, const ShoulderPose& shoulder) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Eigen::Array2d low(kNone, kNone);
  Eigen::Array2d high(-kNone, -kNone);
  for (const Row& row : rows) {
    if (row.is_missing || !is_finite(row)) continue;
    const Eigen::Array2d position = tonus::convert(rig, shoulder, row.raw).p_SE.array();
    low = low.min(position);
    high = high.max(position);
  }
  if (axes_of(rig) == 1) low[1] = high[1] = 0.0;
  return std::max(0.0, (high - low).maxCoeff());
}

/// Rows of a recording that may be missing: it is identified by the segments between the gaps.
std::uint64_t allowed_gaps(std::size_t rows, const JudgeLimits& limits) {
  return static_cast<std::uint64_t>(limits.recording_gaps * static_cast<double>(rows));
}

}  // namespace

JudgeLimits JudgeChoice::limits(bool is_rotary) const {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  JudgeLimits chosen;
  if (is_reaching || is_rotary) {
    chosen.start_offset = chosen.excursion = chosen.rest_speed = chosen.end_speed = kAny;
    chosen.rest_force = chosen.rest_force_change = kAny;
    chosen.resistance = 0.0;
  }
  constexpr double kTwoTurns = 12.6;  // rad
  if (is_rotary) chosen.recording_range = kTwoTurns;
  const auto take = [](const std::optional<double>& single, double& limit) {
    limit = single.value_or(limit);
  };
  take(start_offset, chosen.start_offset);
  take(excursion, chosen.excursion);
  take(rest_speed, chosen.rest_speed);
  take(rest_force, chosen.rest_force);
  take(end_speed, chosen.end_speed);
  return chosen;
}

std::string_view name_of(Defect defect) {
  switch (defect) {
    case Defect::kNotCompleted:
      return "not completed";
    case Defect::kOffTarget:
      return "off target";
    case Defect::kBiasNotReached:
      return "bias not reached";
    case Defect::kBiasNotHeld:
      return "bias not held";
    case Defect::kEarlyReaction:
      return "early reaction";
    case Defect::kSaturated:
      return "saturated";
    case Defect::kGap:
      return "gap";
    case Defect::kExcursion:
      return "excursion";
    case Defect::kNotAtRest:
      return "not at rest";
    case Defect::kUnknownRig:
      return "unknown rig";
    case Defect::kLetGo:
      return "let go";
    case Defect::kMusclesActive:
      return "muscles active";
  }
  return "unknown";
}

Verdict TrialJudge::judge(const MeasuredTrial& trial, const RigGeometry* rig) const {
  const TrialReport& report = trial.report;
  const bool is_recording = report.plan.kind == TrialKind::kRecording;
  Findings findings;
  Measured measured;
  measured.missing_rows = trial.missing_rows;

  if (report.end != TrialEnd::kCompleted) {
    const auto defect =
        report.end == TrialEnd::kBiasNotReached ? Defect::kBiasNotReached : Defect::kNotCompleted;
    findings.add(
        defect, fmt::format("{}{}{}", name_of(report.end), report.detail.empty() ? "" : ", ", report.detail));
    return std::move(findings).verdict(measured, {});
  }
  const bool is_contraction = report.plan.kind == TrialKind::kContraction;
  const bool has_onset = is_contraction || report.range.contains(report.onset);
  if (trial.rows.empty() || !(report.sample_rate > 0.0) || (!is_recording && !has_onset)) {
    findings.add(Defect::kGap,
                 fmt::format("rows {} to {}, onset {}, at {} Hz cannot be put together", report.range.first,
                             report.range.last(), report.onset, report.sample_rate));
    return std::move(findings).verdict(measured, {});
  }

  const bool is_whole = is_recording || is_contraction;
  const auto onset = is_whole ? 0 : static_cast<std::size_t>(report.onset - report.range.first);
  Section judged{0, trial.rows.size()};
  if (!is_whole) {
    judged = {rest_before(trial.rows, onset, rows_of(limits_.rest, report.sample_rate)).first,
              perturbation_from(trial.rows, onset).end};
  }
  const auto rows = std::span(trial.rows).subspan(judged.first, judged.rows());
  measured.saturated_rows = static_cast<std::uint64_t>(std::count_if(
      rows.begin(), rows.end(), [&](const Row& row) { return !row.is_missing && is_saturated(row, rig); }));
  measured.missing_rows = missing_rows(trial.rows, report.sample_rate);

  findings.add_if(
      measured.saturated_rows > 0 && !is_contraction, Defect::kSaturated,
      fmt::format("{} rows with the force sensor at its limit, allowed none", measured.saturated_rows));
  findings.add_if(
      is_recording ? measured.missing_rows > allowed_gaps(trial.rows.size(), limits_)
                   : measured.missing_rows > 0,
      Defect::kGap,
      fmt::format("{} of {} rows missing, allowed {}", measured.missing_rows, trial.rows.size(),
                  is_recording ? std::to_string(allowed_gaps(trial.rows.size(), limits_)) : "none"));
  findings.add_if(rig == nullptr, Defect::kUnknownRig, "no description to convert with");
  if (is_recording) {
    if (rig != nullptr) {
      measured.excursion = range_of(rows, *rig, report.plan.shoulder);
      findings.add_if(measured.excursion > limits_.recording_range, Defect::kExcursion,
                      fmt::format("moved by {:.3g}, allowed {:.3g}: check the unit of the displacement",
                                  measured.excursion, limits_.recording_range));
    }
    return std::move(findings).verdict(measured, "valid: complete, not saturated");
  }
  if (is_contraction) return std::move(findings).verdict(measured, "valid: complete");
  if (measured.missing_rows > 0 || rig == nullptr) return std::move(findings).verdict(measured, {});

  const Traces traces = traces_of(trial, onset, *rig, limits_);
  if (traces.rest.rows() < rows_of(limits_.least_rest, report.sample_rate)) {
    findings.add(Defect::kNotCompleted,
                 fmt::format("{} rows of rest before the onset, needed {}", traces.rest.rows(),
                             rows_of(limits_.least_rest, report.sample_rate)));
    return std::move(findings).verdict(measured, {});
  }
  measure(traces, report, limits_, axes_of(*rig), measured);
  judge_motion(report.plan, traces.is_hold_timed, measured, limits_, findings);
  return std::move(findings).verdict(measured, summary(measured, limits_, report.plan.is_loaded()));
}

}  // namespace tonus::identification
