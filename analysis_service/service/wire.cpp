#include "analysis_service/service/wire.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/ellipse.hpp"
#include "analysis_service/impedance/uncertainty.hpp"

namespace tonus::identification {
namespace {

constexpr std::size_t kMostReasons = 16;  // as the .idl files bound them
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

Eigen::Vector2d vector(const std::array<double, 2>& values) { return {values[0], values[1]}; }

TrialKind from_wire_kind(v1::TrialKind wire) {
  switch (wire) {
    case v1::TRIAL_PERTURBATION:
      return TrialKind::kPerturbation;
    case v1::TRIAL_RECORDING:
      return TrialKind::kRecording;
    case v1::TRIAL_CONTRACTION:
      return TrialKind::kContraction;
  }
  return TrialKind::kPerturbation;
}

TrialPlan plan_of(const Id& trial, const v1::TrialProgram& wire) {
  TrialPlan plan;
  plan.trial = trial;
  plan.session = wire.session_id();
  plan.rig = wire.rig_id();
  plan.attempt = wire.attempt();
  plan.planned_index = wire.planned_index();
  plan.kind = from_wire_kind(wire.kind());
  plan.posture = wire.posture();
  plan.posture_index = wire.posture_index();
  plan.position = vector(wire.posture_m());
  plan.shoulder = contract::shoulder_of(wire);
  plan.set = wire.set_number();
  plan.instruction = wire.instruction();
  plan.bias = vector(wire.bias_N());
  plan.bias_hold = wire.bias_hold_s();
  plan.bias_threshold = wire.bias_threshold_N();
  return plan;
}

/// A phase of a newer contract is none that rest or perturbation could be made of.
Phase from_wire_phase(std::uint8_t wire) {
  switch (wire) {
    case v1::PHASE_IDLE:
      return Phase::kIdle;
    case v1::PHASE_CENTRING:
      return Phase::kCentring;
    case v1::PHASE_WAITING:
      return Phase::kWaiting;
    case v1::PHASE_BIAS_RAMP:
      return Phase::kBiasRamp;
    case v1::PHASE_BIAS_HOLD:
      return Phase::kBiasHold;
    case v1::PHASE_PERTURBING:
      return Phase::kPerturbing;
    case v1::PHASE_RETURNING:
      return Phase::kReturning;
    case v1::PHASE_SAFE:
    default:
      return Phase::kSafe;
  }
}

TrialEnd from_wire_end(v1::TrialEnd wire) {
  switch (wire) {
    case v1::TRIAL_COMPLETED:
      return TrialEnd::kCompleted;
    case v1::TRIAL_ABORTED:
      return TrialEnd::kAborted;
    case v1::TRIAL_FAULTED:
      return TrialEnd::kFaulted;
    case v1::TRIAL_NOT_CENTRED:
      return TrialEnd::kNotCentred;
    case v1::TRIAL_BIAS_NOT_REACHED:
      return TrialEnd::kBiasNotReached;
    case v1::TRIAL_REFUSED:
      return TrialEnd::kRefused;
    case v1::TRIAL_BROKEN_OFF:
      return TrialEnd::kBrokenOff;
  }
  return TrialEnd::kBrokenOff;
}

v1::EstimateStatus to_wire_status(impedance::Status status) {
  switch (status) {
    case impedance::Status::kOk:
      return v1::ESTIMATE_OK;
    case impedance::Status::kUndetermined:
      return v1::ESTIMATE_UNDETERMINED;
    case impedance::Status::kSuspect:
      return v1::ESTIMATE_SUSPECT;
  }
  return v1::ESTIMATE_UNDETERMINED;
}

/// Row-major 2x2; zeros where there is no such matrix.
std::array<double, 4> elements(const impedance::AxisMatrix& matrix) {
  std::array<double, 4> values{};
  if (matrix.rows() > 2 || matrix.cols() > 2) return values;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j)
      values[static_cast<std::size_t>(2 * i + j)] = matrix(i, j);
  }
  return values;
}

std::array<double, 2> elements(const impedance::AxisVector& vector) {
  std::array<double, 2> values{};
  for (Eigen::Index i = 0; i < vector.size(); ++i) values[static_cast<std::size_t>(i)] = vector[i];
  return values;
}

void set_intervals(const impedance::EllipseIntervals& intervals, v1::MatrixEstimate& wire) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  wire.size_low95(intervals.size.low);
  wire.size_high95(intervals.size.high);
  wire.shape_low95(intervals.shape.low);
  wire.shape_high95(intervals.shape.high);
  wire.orientation_low95_deg(kDegrees * intervals.orientation.low);
  wire.orientation_high95_deg(kDegrees * intervals.orientation.high);
  wire.curl_low95(intervals.curl.low);
  wire.curl_high95(intervals.curl.high);
}

v1::MatrixEstimate to_wire_matrix(const impedance::Estimate& estimate,
                                  impedance::AxisMatrix impedance::Parameters::*matrix) {
  v1::MatrixEstimate wire = unknown_matrix();
  wire.value(elements(estimate.value.*matrix));
  wire.standard_error(elements(estimate.std.*matrix));
  wire.low95(elements(estimate.low.*matrix));
  wire.high95(elements(estimate.high.*matrix));
  const impedance::MatrixUncertainty& uncertainty = impedance::uncertainty_of(estimate, matrix);
  set_covariance(uncertainty.covariance, wire);
  if (uncertainty.known_bias.size() > 0) wire.known_bias(elements(uncertainty.known_bias));
  const impedance::AxisMatrix& value = estimate.value.*matrix;
  if (value.rows() != 2 || value.cols() != 2) return wire;
  set_ellipse(Eigen::Matrix2d(value), uncertainty.ellipse, wire);
  return wire;
}

/// A reason's name, with its numbers where it has some.
std::string text_of(const impedance::Estimate& estimate, impedance::Reason reason) {
  const std::string name(impedance::name_of(reason));
  const auto detail = estimate.details.find(reason);
  return detail == estimate.details.end() ? name : name + ": " + detail->second;
}

v1::FitTest to_wire_test(impedance::FitTest test) {
  using impedance::FitTest;
  switch (test) {
    case FitTest::kExplainedShare:
      return v1::FIT_EXPLAINED_SHARE;
    case FitTest::kCoherence:
      return v1::FIT_COHERENCE;
    case FitTest::kHalves:
      return v1::FIT_HALVES;
    case FitTest::kSteadiness:
      return v1::FIT_STEADINESS;
    case FitTest::kBands:
      return v1::FIT_BANDS;
    case FitTest::kLag:
      return v1::FIT_LAG;
    case FitTest::kUnits:
      return v1::FIT_UNITS;
    case FitTest::kFriction:
      return v1::FIT_FRICTION;
    case FitTest::kHardening:
      return v1::FIT_HARDENING;
    case FitTest::kReflex:
      return v1::FIT_REFLEX;
    case FitTest::kPosition:
      return v1::FIT_POSITION;
    case FitTest::kClipping:
      return v1::FIT_CLIPPING;
    case FitTest::kHeldSamples:
      return v1::FIT_HELD_SAMPLES;
    case FitTest::kCrossCheck:
      return v1::FIT_CROSS_CHECK;
    case FitTest::kWidth:
      return v1::FIT_WIDTH;
  }
  return v1::FIT_WIDTH;
}

std::vector<v1::FitCheck> checks_of(const impedance::Estimate& estimate) {
  std::vector<v1::FitCheck> checks;
  for (const impedance::FitCheck& check : estimate.checks) {
    v1::FitCheck wire;
    wire.test(to_wire_test(check.test));
    wire.value(check.value);
    wire.limit(check.limit);
    wire.passed(check.is_passed);
    checks.push_back(wire);
  }
  return checks;
}

/// "N", "N/m^3", "N s/m", "s"
std::string unit_of(const impedance::ModelParameter& parameter, const RigUnits& units) {
  std::string text = parameter.force > 0 ? units.force : "";
  if (parameter.time > 0) text += text.empty() ? "s" : " s";
  if (parameter.length == 1) text += "/" + units.displacement;
  if (parameter.length > 1) text += fmt::format("/{}^{}", units.displacement, parameter.length);
  return text;
}

std::vector<v1::ModelParameter> parameters_of(const impedance::Estimate& estimate, const RigUnits& units) {
  std::vector<v1::ModelParameter> parameters;
  for (const impedance::ModelParameter& parameter : estimate.parameters) {
    v1::ModelParameter wire;
    wire.name(parameter.name);
    wire.unit(unit_of(parameter, units));
    wire.value(parameter.value);
    wire.standard_error(parameter.std);
    wire.low95(parameter.low);
    wire.high95(parameter.high);
    parameters.push_back(wire);
  }
  return parameters;
}

/// By axis; not known where there is none.
std::array<double, 2> elements_or_unknown(const impedance::AxisVector& vector) {
  std::array<double, 2> values{kUnknown, kUnknown};
  for (Eigen::Index i = 0; i < vector.size(); ++i) values[static_cast<std::size_t>(i)] = vector[i];
  return values;
}

std::vector<std::string> reasons_of(const ConditionEstimate& estimate) {
  std::vector<std::string> reasons;
  for (const auto reason : estimate.estimate.reasons) reasons.push_back(text_of(estimate.estimate, reason));
  if (!estimate.refusal.empty()) reasons.push_back(estimate.refusal);
  for (const auto& rejected : estimate.estimate.trials_rejected) {
    reasons.push_back(fmt::format("trial {}: {}", rejected.number, impedance::name_of(rejected.reason)));
  }
  if (reasons.size() > kMostReasons) {
    const std::size_t left_out = reasons.size() - (kMostReasons - 1);
    reasons.resize(kMostReasons - 1);
    reasons.push_back(fmt::format("and {} more", left_out));
  }
  return reasons;
}

v1::TrialRange to_wire_range(const TrialSource& source) {
  v1::TrialRange wire;
  wire.attempt(source.attempt);
  wire.epoch(source.epoch);
  wire.first_sequence(source.range.first);
  wire.onset_sequence(source.onset);
  wire.last_sequence(source.range.last());
  return wire;
}

std::uint32_t to_count(std::uint64_t count) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(count, std::numeric_limits<std::uint32_t>::max()));
}

}  // namespace

v1::MatrixEstimate unknown_matrix() {
  v1::MatrixEstimate wire;
  wire.covariance().fill(kUnknown);
  wire.known_bias().fill(kUnknown);
  wire.size_low95(kUnknown);
  wire.size_high95(kUnknown);
  wire.shape_low95(kUnknown);
  wire.shape_high95(kUnknown);
  wire.orientation_low95_deg(kUnknown);
  wire.orientation_high95_deg(kUnknown);
  wire.curl_low95(kUnknown);
  wire.curl_high95(kUnknown);
  return wire;
}

void set_covariance(const Eigen::MatrixXd& covariance, v1::MatrixEstimate& wire) {
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    for (Eigen::Index j = 0; j < covariance.cols(); ++j)
      wire.covariance()[static_cast<std::size_t>(4 * i + j)] = covariance(i, j);
  }
}

void set_ellipse(const Eigen::Matrix2d& Z, const std::optional<impedance::EllipseIntervals>& intervals,
                 v1::MatrixEstimate& wire) {
  const auto ellipse = impedance::ellipse_of(Z);
  if (!ellipse) return;
  wire.has_ellipse(true);
  wire.size(ellipse->size);
  wire.shape(ellipse->shape);
  wire.orientation_deg(ellipse->orientation * 180.0 / std::numbers::pi);
  if (const auto curl = impedance::curl_of(Z)) wire.curl(curl->p_mean);
  if (intervals) set_intervals(*intervals, wire);
}

Row from_wire(const v1::RigSample& wire) {
  const contract::SampleFlags flags = contract::flags_of(wire);
  Row row;
  row.raw.acquisition_ns = wire.acquisition_ns();
  row.raw.encoder_count = wire.encoder_count();
  row.raw.force_V = wire.force_V();
  row.commanded = wire.commanded_m();
  row.phase = from_wire_phase(wire.phase());
  row.is_saturated = flags.is_saturated;
  row.is_missing = flags.is_missing;
  return row;
}

RowBlock from_wire(const v1::SampleBlock& wire, std::vector<Row>& rows) {
  rows.clear();
  rows.reserve(wire.samples().size());
  for (const v1::RigSample& sample : wire.samples()) rows.push_back(from_wire(sample));
  return {wire.rig_id(), wire.trial_id(), wire.epoch(), wire.first_sequence(), rows};
}

AuxiliaryRows from_wire(const v1::AuxiliaryBlock& wire) {
  return {wire.rig_id(),         wire.trial_id(),     wire.epoch(),
          wire.first_sequence(), wire.sample_count(), wire.values()};
}

TrialPlan from_wire(const v1::TrialCommand& wire) { return plan_of(wire.trial_id(), wire.program()); }

TrialReport from_wire(const v1::TrialOutcome& wire) {
  TrialReport report;
  report.plan = plan_of(wire.trial_id(), wire.program());
  report.epoch = wire.epoch();
  report.end = from_wire_end(wire.end());
  report.detail = wire.detail();
  report.range = SequenceRange::from_first_to_last(wire.first_sequence(), wire.last_sequence());
  report.onset = wire.onset_sequence();
  report.sample_rate = wire.sample_rate_Hz();
  return report;
}

v1::VerdictReason to_wire(Defect defect) {
  switch (defect) {
    case Defect::kNotCompleted:
      return v1::REASON_NOT_COMPLETED;
    case Defect::kOffTarget:
      return v1::REASON_OFF_TARGET;
    case Defect::kBiasNotReached:
      return v1::REASON_BIAS_NOT_REACHED;
    case Defect::kBiasNotHeld:
      return v1::REASON_BIAS_NOT_HELD;
    case Defect::kEarlyReaction:
      return v1::REASON_EARLY_REACTION;
    case Defect::kSaturated:
      return v1::REASON_SATURATED;
    case Defect::kGap:
      return v1::REASON_GAP;
    case Defect::kExcursion:
      return v1::REASON_EXCURSION;
    case Defect::kNotAtRest:
      return v1::REASON_NOT_AT_REST;
    case Defect::kUnknownRig:
      return v1::REASON_UNKNOWN_RIG;
    case Defect::kLetGo:
      return v1::REASON_LET_GO;
    case Defect::kMusclesActive:
      return v1::REASON_MUSCLES_ACTIVE;
  }
  return v1::REASON_NOT_COMPLETED;
}

v1::TrialVerdict to_wire(const TrialReport& report, const Verdict& verdict) {
  v1::TrialVerdict wire;
  wire.trial_id(report.plan.trial);
  wire.session_id(report.plan.session);
  wire.attempt(report.plan.attempt);
  wire.planned_index(report.plan.planned_index);
  wire.posture_index(report.plan.posture_index);
  wire.is_valid(verdict.is_valid);
  for (const Defect defect : verdict.defects) wire.reasons().push_back(to_wire(defect));
  wire.detail(verdict.detail);
  wire.start_offset_m(verdict.measured.start_offset);
  wire.rest_speed_m_per_s(verdict.measured.rest_speed);
  wire.rest_force_N(verdict.measured.rest_force);
  wire.excursion_m(verdict.measured.excursion);
  wire.end_speed_m_per_s(verdict.measured.end_speed);
  wire.saturated_samples(to_count(verdict.measured.saturated_rows));
  wire.missing_samples(to_count(verdict.measured.missing_rows));
  for (const muscles::Activity& muscle : verdict.activity.muscles) {
    v1::MuscleActivity activity;
    activity.channel(muscle.channel);
    activity.is_normalised(muscle.is_normalised);
    activity.before_onset(muscle.before_onset);
    activity.short_latency(muscle.short_latency);
    activity.long_latency(muscle.long_latency);
    wire.muscles().push_back(activity);
  }
  wire.co_contraction(verdict.activity.co_contraction);
  return wire;
}

v1::ArchiveResend to_wire(const ResendRequest& request) {
  v1::ArchiveResend wire;
  wire.rig_id(request.rig);
  wire.epoch(request.epoch);
  wire.first_sequence(request.range.first);
  wire.last_sequence(request.range.last());
  wire.requested_by("identification");
  return wire;
}

v1::Estimate to_wire(const ConditionEstimate& estimate, const RigUnits& units) {
  const Condition& condition = estimate.condition;
  const impedance::Estimate& found = estimate.estimate;
  const bool is_state_variable = found.method == impedance::Method::kStateVariable;
  v1::Estimate wire;
  // An automatic choice may change as data come: it stays the same estimate.
  const bool is_automatic = estimate.options.model == impedance::Model::kAutomatic;
  wire.estimate_id(
      estimate_id(condition, found.method, is_automatic ? impedance::Model::kAutomatic : found.model));
  wire.session_id(condition.session);
  wire.rig_id(condition.rig);
  wire.posture(condition.posture);
  wire.posture_index(condition.posture_index);
  wire.posture_m({condition.position[0], condition.position[1]});
  wire.bias_N({condition.bias[0], condition.bias[1]});
  wire.set_number(condition.set);
  wire.instruction(condition.instruction);
  wire.method(std::string(impedance::name_of(found.method)));
  wire.model(std::string(impedance::name_of(found.model)));
  wire.axes(static_cast<std::uint32_t>(found.axes));
  wire.displacement_unit(units.displacement);
  wire.force_unit(units.force);
  wire.status(to_wire_status(found.status));
  wire.reasons(reasons_of(estimate));
  wire.trials_used(to_count(found.trials_used.size()));
  wire.trials_rejected(to_count(estimate.invalid_trials + found.trials_rejected.size()));
  wire.samples(static_cast<std::uint64_t>(found.samples));
  wire.mass_kg(to_wire_matrix(found, &impedance::Parameters::M));
  wire.damping_Ns_per_m(to_wire_matrix(found, &impedance::Parameters::B));
  wire.stiffness_N_per_m(to_wire_matrix(found, &impedance::Parameters::K));
  v1::VectorEstimate centre;
  centre.value(elements(found.value.X0));
  centre.covariance().fill(kUnknown);
  for (Eigen::Index i = 0; i < found.X0_covariance.rows(); ++i) {
    for (Eigen::Index j = 0; j < found.X0_covariance.cols(); ++j)
      centre.covariance()[static_cast<std::size_t>(2 * i + j)] = found.X0_covariance(i, j);
  }
  centre.standard_error(elements(found.std.X0));
  centre.low95(elements(found.low.X0));
  centre.high95(elements(found.high.X0));
  wire.spring_centre_m(centre);
  wire.sigma_N(elements(found.sigma));
  wire.condition_number(found.condition_number);
  wire.degrees_of_freedom(found.units > 1 ? static_cast<double>(found.units - 1) : 0.0);
  wire.natural_frequency_Hz(is_state_variable ? found.natural_frequency : 0.0);
  wire.damping_ratio(is_state_variable ? estimate.options.damping_ratio : 0.0);
  wire.cutoff_Hz(found.method == impedance::Method::kLowpass ? estimate.options.cutoff : 0.0);
  wire.window_s(found.method == impedance::Method::kSpectral ? found.segment_duration
                                                             : estimate.options.window);
  wire.settled_s(found.settling_time.value_or(-1.0));
  wire.explained_share(found.explained.size() > 0 ? found.explained.minCoeff()
                                                  : std::numeric_limits<double>::quiet_NaN());
  wire.lag_s(elements_or_unknown(found.force_lag));
  wire.lag_low95_s(elements_or_unknown(found.force_lag_low));
  wire.lag_high95_s(elements_or_unknown(found.force_lag_high));
  wire.band_low_Hz(found.band_low);
  wire.band_high_Hz(found.band_high);
  wire.independent_units(to_count(found.units));
  wire.checks(checks_of(found));
  wire.parameters(parameters_of(found, units));
  wire.compared_models(found.compared);
  for (const TrialSource& source : estimate.trials) wire.trials().push_back(to_wire_range(source));
  return wire;
}

}  // namespace tonus::identification
