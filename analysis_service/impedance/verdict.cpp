#include "analysis_service/impedance/verdict.hpp"

#include <algorithm>

#include "analysis_service/impedance/ellipse.hpp"

namespace tonus::impedance {
namespace {

bool is_positive_definite(const AxisMatrix& Z) {
  return Z.rows() == 1 ? Z(0, 0) > 0.0 : not_an_ellipse(Eigen::Matrix2d(Z)) == "ok";
}

}  // namespace

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
  }
  return "unknown";
}

void conclude(Estimate& estimate, std::optional<Reason> failure, const Diagnosis& diagnosis) {
  const auto add = [&](bool is_so, Reason reason) {
    if (is_so) estimate.reasons.push_back(reason);
  };
  if (failure) estimate.reasons.push_back(*failure);
  add(diagnosis.is_force_collinear, Reason::kCollinearForce);
  add(diagnosis.is_force_shifted, Reason::kForceShifted);
  add(diagnosis.is_force_clipped, Reason::kClippedForce);
  if (failure) {
    estimate.status = Status::kUndetermined;
    estimate.value = estimate.std = estimate.low = estimate.high = {};
    estimate.covariance.resize(0, 0);
    estimate.trace.clear();
    estimate.settling_time.reset();
  } else {
    add(!is_positive_definite(estimate.value.K), Reason::kNegativeStiffness);
    add(!is_positive_definite(estimate.value.M), Reason::kNegativeMass);
    add(estimate.model == Model::kLinear && !is_positive_definite(estimate.value.B),
        Reason::kNegativeDamping);
    estimate.status = estimate.reasons.empty() ? Status::kOk : Status::kSuspect;
  }
  std::ranges::sort(estimate.reasons);
}

}  // namespace tonus::impedance
