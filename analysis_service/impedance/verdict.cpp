#include "analysis_service/impedance/verdict.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "analysis_service/impedance/ellipse.hpp"
#include "analysis_service/impedance/force_lag.hpp"
#include "analysis_service/impedance/model_tests.hpp"
#include "analysis_service/statistics/distributions.hpp"

namespace tonus::impedance {
namespace {

constexpr double kMostMisfit = 3.0;  // of the mean response, in what the trials' own scatter makes of it
constexpr double kMostMisfitShare = 0.02;  // of the mean response's force
constexpr double kSymmetryLevel = 1e-4;    // one-sided
constexpr double kMostAsymmetry = 0.04;    // of the largest mass, between the off-diagonal elements

bool is_positive_definite(const AxisMatrix& Z) {
  return Z.rows() == 1 ? Z(0, 0) > 0.0 : not_an_ellipse(Eigen::Matrix2d(Z)) == "ok";
}

/// What a force of the opposite sign looks like.
bool is_every_diagonal_negative(const Estimate& estimate) {
  if (!is_record_model(estimate.model)) return false;
  for (const AxisMatrix* matrix : {&estimate.value.M, &estimate.value.B, &estimate.value.K}) {
    if (!(matrix->diagonal().maxCoeff() < 0.0)) return false;
  }
  return true;
}

/// Mass is symmetric: kinetic energy is a square.
void check_symmetry(Estimate& estimate) {
  const Eigen::Index regressors = estimate.covariance.rows() / 2;
  if (estimate.axes != 2 || estimate.model != Model::kLinear || estimate.units < 2 || regressors < 2) return;
  const Eigen::MatrixXd& C = estimate.covariance;  // of M(0, j) at j, of M(1, j) at regressors + j
  const double difference = std::abs(estimate.value.M(0, 1) - estimate.value.M(1, 0));
  const double deviation =
      std::sqrt(std::max(0.0, C(1, 1) + C(regressors, regressors) - C(1, regressors) - C(regressors, 1)));
  const double largest = estimate.value.M.cwiseAbs().maxCoeff();
  const double half = 0.5 * (estimate.high.M - estimate.low.M).maxCoeff();
  const double strict =
      statistics::student_t_quantile(1.0 - kSymmetryLevel, static_cast<double>(estimate.units - 1)) *
      deviation;
  const double limit = std::max({strict, kMostAsymmetry * largest, half});
  if (difference <= limit) return;
  estimate.reasons.push_back(Reason::kAsymmetricMass);
  estimate.details[Reason::kAsymmetricMass] = fmt::format(
      "the off-diagonal elements of the mass matrix differ by {:.3g} % of its largest, at most {:.3g} %",
      100.0 * difference / largest, 100.0 * limit / largest);
}

void check_fit(Estimate& estimate, const Diagnosis& diagnosis) {
  const auto add = [&](FitTest test, double value, double limit, bool is_passed, Reason reason,
                       std::string detail) {
    add_check(test, value, limit, is_passed, reason, std::move(detail), estimate);
  };
  const double explained = estimate.explained.minCoeff();
  add(FitTest::kExplainedShare, explained, kLeastExplained, explained >= kLeastExplained,
      Reason::kUnexplained,
      fmt::format("the model explains {:.3g} % of the force, at least {:.3g} %", 100.0 * explained,
                  100.0 * kLeastExplained));
  const bool has_tests = diagnosis.model_tests != nullptr;
  if (has_tests && diagnosis.is_by_mean_motion) {
    check_against_mean_motion(*diagnosis.model_tests, estimate);
  } else if (has_tests) {
    check_against_model(*diagnosis.model_tests, estimate);
  } else if (diagnosis.is_lag_examined) {
    const double lag = diagnosis.force_lag.cwiseAbs().maxCoeff();
    const bool is_passed = !diagnosis.is_force_shifted;
    estimate.checks.push_back(
        {FitTest::kLag, lag, is_passed ? std::max(kLagTolerated, lag) : kLagTolerated, is_passed});
  }
  const bool has_misfit = has_tests && !diagnosis.is_by_mean_motion;
  if (!has_misfit && diagnosis.is_lag_examined && estimate.model == Model::kLinear) {
    const bool is_passed = diagnosis.misfit < kMostMisfit || diagnosis.misfit_share < kMostMisfitShare;
    const double share = diagnosis.misfit_share;
    add(FitTest::kBands, share, is_passed ? std::max(share, kMostMisfitShare) : kMostMisfitShare, is_passed,
        Reason::kMisfit,
        fmt::format("the model leaves {:.3g} % of the force's mean response, at most {:.3g} %", 100.0 * share,
                    100.0 * kMostMisfitShare));
  }
  const auto units = static_cast<double>(estimate.units);
  add(FitTest::kUnits, units, kFewestUnits, estimate.units >= kFewestUnits, Reason::kFewUnits,
      fmt::format("{} independent units, at least {}", estimate.units, kFewestUnits));
}

}  // namespace

void add_check(FitTest test, double value, double limit, bool is_passed, Reason reason, std::string detail,
               Estimate& estimate) {
  estimate.checks.push_back({test, value, limit, is_passed});
  if (is_passed) return;
  estimate.reasons.push_back(reason);
  estimate.details[reason] = std::move(detail);
}

std::string_view name_of(Status status) {
  switch (status) {
    case Status::kUndetermined:
      return "undetermined";
    case Status::kOk:
      return "ok";
    case Status::kSuspect:
      return "suspect";
  }
  return "unknown";
}

std::string_view name_of(Reason reason) {
  switch (reason) {
    case Reason::kTooFewTrials:
      return "too_few_trials";
    case Reason::kSingleDirection:
      return "single_direction";
    case Reason::kRankDeficient:
      return "rank_deficient";
    case Reason::kNegativeStiffness:
      return "negative_stiffness";
    case Reason::kNegativeMass:
      return "negative_mass";
    case Reason::kNegativeDamping:
      return "negative_damping";
    case Reason::kCollinearForce:
      return "collinear_force";
    case Reason::kForceShifted:
      return "force_shifted";
    case Reason::kClippedForce:
      return "clipped_force";
    case Reason::kShortTrial:
      return "short_trial";
    case Reason::kForceSign:
      return "force_sign";
    case Reason::kNoCommand:
      return "no_command";
    case Reason::kTooFewSamples:
      return "too_few_samples";
    case Reason::kNoMotion:
      return "no_motion";
    case Reason::kTooFewSegments:
      return "too_few_segments";
    case Reason::kNotCoherent:
      return "not_coherent";
    case Reason::kWide:
      return "wide_interval";
    case Reason::kUnexplained:
      return "unexplained_force";
    case Reason::kIncoherent:
      return "incoherent";
    case Reason::kHalvesDiffer:
      return "halves_differ";
    case Reason::kUnsteady:
      return "unsteady";
    case Reason::kMisfit:
      return "misfit";
    case Reason::kLag:
      return "lag";
    case Reason::kFewUnits:
      return "few_units";
    case Reason::kFriction:
      return "friction";
    case Reason::kHardening:
      return "hardening";
    case Reason::kPositionDependent:
      return "position_dependent";
    case Reason::kHeldSamples:
      return "held_samples";
    case Reason::kReflex:
      return "reflex";
    case Reason::kUnsettledModel:
      return "unsettled_model";
    case Reason::kAsymmetricMass:
      return "asymmetric_mass";
    case Reason::kAtBound:
      return "at_bound";
    case Reason::kSlack:
      return "slack";
    case Reason::kMethodsDiffer:
      return "methods_differ";
  }
  return "unknown";
}

void conclude(Estimate& estimate, std::optional<Reason> failure, const Diagnosis& diagnosis) {
  if (estimate.checks.empty() && !failure) check_fit(estimate, diagnosis);
  const auto add = [&](bool is_so, Reason reason) {
    if (is_so) estimate.reasons.push_back(reason);
  };
  if (failure) estimate.reasons.push_back(*failure);
  if (!failure) check_symmetry(estimate);
  if (diagnosis.cross_check && !failure) {
    const CrossCheck& check = *diagnosis.cross_check;
    estimate.checks.push_back({FitTest::kCrossCheck, check.value, kLargestDifference, check.is_passed()});
    add(!check.is_passed(), Reason::kMethodsDiffer);
    if (!check.is_passed()) estimate.details[Reason::kMethodsDiffer] = check.detail;
  }
  add(diagnosis.is_force_collinear, Reason::kCollinearForce);
  add(diagnosis.is_force_shifted, Reason::kForceShifted);
  add(diagnosis.is_force_clipped, Reason::kClippedForce);
  if (failure) {
    estimate.status = Status::kUndetermined;
    estimate.value = estimate.std = estimate.low = estimate.high = {};
    estimate.covariance.resize(0, 0);
    estimate.uncertainty = {};
    estimate.X0_covariance.resize(0, 0);
    estimate.parameters.clear();
    estimate.trace.clear();
    estimate.settling_time.reset();
  } else if (is_every_diagonal_negative(estimate)) {
    estimate.reasons.push_back(Reason::kForceSign);
    estimate.details[Reason::kForceSign] =
        "M, B and K are all negative: the force is that of the limb on the rig; state --force-sign -1";
    estimate.status = Status::kSuspect;
  } else {
    add(!is_positive_definite(estimate.value.K), Reason::kNegativeStiffness);
    add(!is_positive_definite(estimate.value.M), Reason::kNegativeMass);
    add(is_record_model(estimate.model) && !is_positive_definite(estimate.value.B), Reason::kNegativeDamping);
    estimate.status = estimate.reasons.empty() ? Status::kOk : Status::kSuspect;
  }
  std::sort(estimate.reasons.begin(), estimate.reasons.end());
  estimate.reasons.erase(std::unique(estimate.reasons.begin(), estimate.reasons.end()),
                         estimate.reasons.end());
}

}  // namespace tonus::impedance
