#include "analysis_service/impedance/record_identification.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/method_bias.hpp"
#include "analysis_service/impedance/uncertainty.hpp"
#include "analysis_service/impedance/verdict.hpp"
#include "analysis_service/spectral/identification.hpp"

namespace tonus::impedance {
namespace {

std::string percent(double share) { return fmt::format("{:.3g} %", 100.0 * share); }

/// What a failed check says. The remedies are in README.md.
struct Finding {
  std::optional<FitTest> test;  ///< None: a reason alone.
  Reason reason = Reason::kUnexplained;
  std::string detail;
};

Finding finding_of(const spectral::Check& check, const spectral::Estimate& found) {
  const double v = check.value;
  const double limit = check.limit;
  using spectral::Test;
  switch (check.test) {
    case Test::kExplainedShare:
      return {FitTest::kExplainedShare, Reason::kUnexplained,
              fmt::format("the model explains {} of the force, at least {}", percent(v), percent(limit))};
    case Test::kCoherence:
      return {FitTest::kCoherence, Reason::kIncoherent,
              fmt::format("mean coherence {:.2f} in the band, at least {:.2f}", v, limit)};
    case Test::kHalves:
      return {FitTest::kHalves, Reason::kHalvesDiffer,
              fmt::format("halves differ by {:.2f} joint 95 % half-widths, at most {:.2f}", v, limit)};
    case Test::kSteadiness:
      return {
          FitTest::kSteadiness, Reason::kUnsteady,
          fmt::format("parts of the record scatter {:.1f} times more than its noise explains, at most {:.1f}",
                      v, limit)};
    case Test::kBands:
      return {FitTest::kBands, Reason::kMisfit,
              fmt::format("the response departs from the model by {} in a band, at most {}{}", percent(v),
                          percent(limit),
                          found.is_part_of_band
                              ? fmt::format("; the numbers are for {:.3g} to {:.3g} Hz, where it holds best",
                                            found.band_low, found.band_high)
                              : std::string{})};
    case Test::kLag:
      return {FitTest::kLag, Reason::kLag,
              fmt::format("the force lags by {:.3g} ms, at most {:.3g} ms either way", 1e3 * v, 1e3 * limit)};
    case Test::kUnits:
      return {FitTest::kUnits, Reason::kFewUnits,
              fmt::format("{:.0f} independent parts, at least {:.0f}", v, limit)};
    case Test::kFriction:
      return {FitTest::kFriction, Reason::kFriction,
              fmt::format("{} of the force follows the velocity's sign or signed square, at most {}",
                          percent(v), percent(limit))};
    case Test::kHardening:
      return {FitTest::kHardening, Reason::kHardening,
              fmt::format("{} of the force follows the cube of the displacement, at most {}", percent(v),
                          percent(limit))};
    case Test::kPosition:
      return {FitTest::kPosition, Reason::kPositionDependent,
              fmt::format("stiffness changes by {} over the positions met, at most {}", percent(v),
                          percent(limit))};
    case Test::kReflex:
      return {FitTest::kReflex, Reason::kReflex,
              fmt::format("{} of the force follows the displacement 30 to 60 ms late, at most {}", percent(v),
                          percent(limit))};
    case Test::kClipping:
      return {FitTest::kClipping, Reason::kClippedForce,
              fmt::format("a channel stands at its end in {} of the samples, at most {}", percent(v),
                          percent(limit))};
    case Test::kHeldSamples:
      return {FitTest::kHeldSamples, Reason::kHeldSamples,
              fmt::format("{} of the samples of a channel repeat or join others, at most {}", percent(v),
                          percent(limit))};
    case Test::kWidth:
      return {FitTest::kWidth, Reason::kWide,
              fmt::format("a 95 % half-width is {} of its matrix, at most {}", percent(v), percent(limit))};
    case Test::kSymmetry:
      return {
          std::nullopt, Reason::kAsymmetricMass,
          fmt::format("the off-diagonal elements of the mass matrix differ by {} of its largest, at most {}",
                      percent(v), percent(limit))};
    case Test::kAtBound:
      return {
          std::nullopt, Reason::kAtBound,
          fmt::format("the reflex's delay is {:.2g} ms from the end of the search, {:.3g} to {:.3g} ms; "
                      "at least its standard error, {:.2g} ms",
                      1e3 * v, 1e3 * spectral::kShortestReflex, 1e3 * spectral::kLongestReflex, 1e3 * limit)};
  }
  return {};
}

Reason reason_of(spectral::Shortage shortage) {
  switch (shortage) {
    case spectral::Shortage::kNone:
    case spectral::Shortage::kTooFewSamples:
      return Reason::kTooFewSamples;
    case spectral::Shortage::kNoMotion:
      return Reason::kNoMotion;
    case spectral::Shortage::kTooFewSegments:
      return Reason::kTooFewSegments;
    case spectral::Shortage::kNotCoherent:
      return Reason::kNotCoherent;
    case spectral::Shortage::kUnsettled:
      return Reason::kUnsettledModel;
    case spectral::Shortage::kTooFewFrequencies:
      return Reason::kRankDeficient;
  }
  return Reason::kTooFewSamples;
}

std::string detail_of(const spectral::Estimate& found, Eigen::Index samples, double seconds) {
  switch (found.shortage) {
    case spectral::Shortage::kNone:
    case spectral::Shortage::kTooFewSamples:
      return fmt::format("{} usable rows, at least {}", samples, spectral::kFewestRows);
    case spectral::Shortage::kNoMotion:
      return "displacement or force of an axis does not change";
    case spectral::Shortage::kTooFewSegments:
      return "the record is too short, or its gaps are too close, for 18 segments";
    case spectral::Shortage::kNotCoherent:
      return fmt::format(
          "fewer than 8 frequencies, {:.2g} Hz apart as {:.3g} s allow, at which force and motion are "
          "coherent on every axis",
          spectral::kSegmentsOfLongest / seconds, seconds);
    case spectral::Shortage::kUnsettled:
      return "the coefficients beside M, B and K do not settle: the data do not tell them apart";
    case spectral::Shortage::kTooFewFrequencies:
      return fmt::format("the motion has {:.2g} independent frequencies, at least {}", found.frequencies,
                         spectral::kFewestFrequencies);
  }
  return {};
}

Eigen::Index usable_rows(std::span<const Trial* const> trials) {
  Eigen::Index rows = 0;
  for (const Trial* trial : trials) rows += trial->samples() - std::ranges::count(trial->is_missing, true);
  return rows;
}

/// X0 of the mean force: the scatter of (19) over parts of the records states its uncertainty.
void set_centre(std::span<const Trial* const> trials, const Eigen::MatrixXd& K, double t95,
                Estimate& estimate) {
  constexpr Eigen::Index kParts = 10;
  const auto axes = K.rows();
  const Eigen::MatrixXd compliance = K.inverse();
  std::vector<Eigen::VectorXd> parts;
  for (const Trial* trial : trials) {
    for (Eigen::Index part = 0; part < kParts; ++part) {
      const Eigen::Index first = part * trial->samples() / kParts;
      const Eigen::Index rows = (part + 1) * trial->samples() / kParts - first;
      parts.emplace_back(trial->displacement.middleRows(first, rows).colwise().mean().transpose() -
                         compliance * trial->force.middleRows(first, rows).colwise().mean().transpose());
    }
  }
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(axes);
  for (const auto& part : parts) mean += part / static_cast<double>(parts.size());
  Eigen::VectorXd square = Eigen::VectorXd::Zero(axes);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(axes, axes);
  for (const auto& part : parts) {
    square += (part - mean).cwiseAbs2();
    products += (part - mean) * (part - mean).transpose();
  }
  const auto count = static_cast<double>(parts.size());
  estimate.value.X0 = mean;
  estimate.X0_covariance = products / (count * (count - 1.0));
  estimate.std.X0 = (square / (count * (count - 1.0))).cwiseSqrt();
  estimate.low.X0 = estimate.value.X0 - t95 * estimate.std.X0;
  estimate.high.X0 = estimate.value.X0 + t95 * estimate.std.X0;
}

spectral::Settings settings_of(Model model) {
  spectral::Settings settings;
  settings.is_automatic = model == Model::kAutomatic;
  if (model == Model::kFriction) settings.addition = spectral::Addition::kFriction;
  if (model == Model::kCubic) settings.addition = spectral::Addition::kCubic;
  if (model == Model::kReflex) settings.addition = spectral::Addition::kReflex;
  return settings;
}

Model model_of(spectral::Addition addition) {
  switch (addition) {
    case spectral::Addition::kNone:
      return Model::kLinear;
    case spectral::Addition::kFriction:
      return Model::kFriction;
    case spectral::Addition::kCubic:
      return Model::kCubic;
    case spectral::Addition::kReflex:
      return Model::kReflex;
  }
  return Model::kLinear;
}

ModelParameter parameter_of(const spectral::Parameter& found, int axes, double t95) {
  using Kind = spectral::Parameter::Kind;
  constexpr const char* kAxes[] = {"x", "y"};
  const std::string own = axes == 1 ? "" : fmt::format("_{}", kAxes[found.force_axis]);
  const std::string both = axes == 1 ? "" : own + kAxes[found.motion_axis];
  ModelParameter parameter;
  switch (found.kind) {
    case Kind::kFriction:
      parameter = {"friction" + own, 1, 0, 0};
      break;
    case Kind::kQuadratic:
      parameter = {"quadratic_stiffness" + own, 1, 0, 2};
      break;
    case Kind::kCubic:
      parameter = {"cubic_stiffness" + own, 1, 0, 3};
      break;
    case Kind::kReflexStiffness:
      parameter = {"reflex_stiffness" + both, 1, 0, 1};
      break;
    case Kind::kReflexDamping:
      parameter = {"reflex_damping" + both, 1, 1, 1};
      break;
    case Kind::kReflexDelay:
      parameter = {"reflex_delay", 0, 1, 0};
      break;
  }
  parameter.value = found.value;
  parameter.std = found.error;
  parameter.low = found.value - t95 * found.error;
  parameter.high = found.value + t95 * found.error;
  return parameter;
}

/// Force over displacement at rest: a reflex adds its stiffness.
Eigen::MatrixXd static_stiffness(const spectral::Estimate& found) {
  Eigen::MatrixXd K = found.K;
  for (const spectral::Parameter& parameter : found.parameters) {
    if (parameter.kind == spectral::Parameter::Kind::kReflexStiffness)
      K(parameter.force_axis, parameter.motion_axis) += parameter.value;
  }
  return K;
}

std::string text_of(const std::vector<spectral::Compared>& compared) {
  std::string text;
  for (const spectral::Compared& one : compared) {
    if (!text.empty()) text += "; ";
    text += fmt::format("{}: {}", name_of(model_of(one.addition)),
                        !one.is_found     ? "does not settle"
                        : one.is_accepted ? "accepted"
                                          : "refused");
    if (one.is_found && one.addition != spectral::Addition::kNone)
      text += fmt::format(", BIC {:+.1f} of linear", one.bic);
  }
  return text;
}

/// The intervals' own t95 states the degrees of freedom: blocks - 1.
void set_spectral_uncertainty(const spectral::Estimate& found, Estimate& estimate) {
  const Eigen::Index size = Eigen::Index{found.axes} * found.axes;
  const double freedom = std::max(1, found.blocks - 1);
  Eigen::Index first = 0;
  for (const auto matrix : {&Parameters::M, &Parameters::B, &Parameters::K}) {
    const Eigen::MatrixXd covariance = found.covariance.block(first, first, size, size);
    const SpreadOf spread_of = [&](const Eigen::Vector4d& weights) {
      const Eigen::VectorXd own = weights.head(size);
      return CombinationSpread{std::sqrt(std::max(0.0, own.dot(covariance * own))), freedom};
    };
    set_uncertainty(matrix, covariance, spread_of, freedom, estimate);
    first += size;
  }
}

}  // namespace

void identify_records(std::span<const Trial* const> trials, Model model, Estimate& estimate) {
  std::vector<spectral::Record> records;
  for (const Trial* trial : trials)
    records.push_back({trial->sample_period, trial->displacement, trial->force, trial->is_missing});
  const spectral::Estimate found = spectral::identify(records, settings_of(model));
  estimate.model = model_of(found.addition);
  estimate.compared = text_of(found.compared);
  estimate.samples = usable_rows(trials);
  Diagnosis diagnosis;
  diagnosis.is_force_clipped = std::ranges::any_of(trials, &Trial::is_clipped);
  if (found.outcome == spectral::Outcome::kNone) {
    const Reason reason = reason_of(found.shortage);
    conclude(estimate, reason, diagnosis);
    estimate.details[reason] = detail_of(
        found, estimate.samples, static_cast<double>(estimate.samples) * trials.front()->sample_period);
    return;
  }
  estimate.units = static_cast<std::size_t>(found.blocks);
  estimate.value.M = found.M;
  estimate.value.M -= trials.front()->handle_mass * Eigen::MatrixXd::Identity(found.axes, found.axes);
  estimate.value.B = found.B;
  estimate.value.K = found.K;
  estimate.std.M = found.M_error;
  estimate.std.B = found.B_error;
  estimate.std.K = found.K_error;
  for (const auto matrix : {&Parameters::M, &Parameters::B, &Parameters::K}) {
    estimate.low.*matrix = estimate.value.*matrix - found.t95 * estimate.std.*matrix;
    estimate.high.*matrix = estimate.value.*matrix + found.t95 * estimate.std.*matrix;
  }
  set_spectral_uncertainty(found, estimate);
  set_centre(trials, static_stiffness(found), found.t95, estimate);
  for (const spectral::Parameter& parameter : found.parameters)
    estimate.parameters.push_back(parameter_of(parameter, found.axes, found.t95));
  estimate.sigma = found.sigma;
  estimate.explained = AxisVector::Constant(found.axes, found.explained);
  estimate.force_lag = found.lag;
  estimate.force_lag_low = found.lag - found.t95 * found.lag_error;
  estimate.force_lag_high = found.lag + found.t95 * found.lag_error;
  estimate.band_low = found.band_low;
  estimate.band_high = found.band_high;
  estimate.segment_duration = found.segment_duration;
  std::optional<Reason> failure;
  for (const spectral::Check& check : found.checks) {
    Finding finding = finding_of(check, found);
    if (finding.test) estimate.checks.push_back({*finding.test, check.value, check.limit, check.is_passed});
    if (check.is_passed) continue;
    const bool is_undetermined =
        finding.reason == Reason::kWide && found.outcome == spectral::Outcome::kUndetermined;
    if (is_undetermined) {
      failure = finding.reason;
    } else {
      estimate.reasons.push_back(finding.reason);
    }
    estimate.details.emplace(finding.reason, std::move(finding.detail));
  }
  conclude(estimate, failure, diagnosis);
}

void hold_against_spectral(const Estimate& spectral, Estimate& estimate) {
  for (const Reason reason : spectral.reasons) {
    estimate.reasons.push_back(reason);
    const auto detail = spectral.details.find(reason);
    if (detail != spectral.details.end()) estimate.details[reason] = "method spectral: " + detail->second;
  }
  if (spectral.status == Status::kUndetermined) return;
  Parameters beyond = estimate.value;
  for (const auto matrix : {&Parameters::M, &Parameters::B, &Parameters::K}) {
    beyond.*matrix = estimate.value.*matrix - spectral.value.*matrix;
    estimate.low.*matrix = (estimate.low.*matrix).cwiseMin(spectral.low.*matrix).eval();
    estimate.high.*matrix = (estimate.high.*matrix).cwiseMax(spectral.high.*matrix).eval();
    const auto& other = uncertainty_of(spectral, matrix).ellipse;
    auto& ellipse = uncertainty_of(estimate, matrix).ellipse;
    if (ellipse && other) ellipse = hull(*ellipse, *other);
  }
  state_bias(beyond, estimate);
}

}  // namespace tonus::impedance
