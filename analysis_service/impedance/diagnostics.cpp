#include "analysis_service/impedance/diagnostics.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "analysis_service/impedance/condition_response.hpp"
#include "analysis_service/impedance/force_lag.hpp"

namespace tonus::impedance {
namespace {

Eigen::Index rows_in(double duration, double sample_period) {
  return static_cast<Eigen::Index>(std::llround(duration / sample_period));
}

/// Smaller over larger root mean square along the principal axes of a scatter (sum of x x').
double spread(const Eigen::Matrix2d& scatter) {
  const Eigen::Vector2d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvalues();
  return values[1] > 0.0 ? std::sqrt(std::max(values[0], 0.0) / values[1]) : 0.0;
}

bool is_one_line(std::span<const Trial* const> trials, double window) {
  const auto commanded = [](const Trial& trial) -> const Signals& { return trial.commanded; };
  const auto measured = [](const Trial& trial) -> const Signals& { return trial.displacement; };
  // A command that is zero throughout is one that was not recorded.
  const bool has_command = std::ranges::all_of(trials, [](const Trial* trial) {
    return trial->commanded.rows() == trial->samples() && !trial->commanded.isZero(0.0);
  });
  const bool is_continuous =
      std::ranges::any_of(trials, [](const Trial* trial) { return trial->is_continuous; });
  if (!is_continuous) {
    const Eigen::MatrixXd means = has_command ? means_over_window(trials, window, commanded)
                                              : means_over_window(trials, window, measured);
    return spread(means.transpose() * means) < kDirectionSpread;
  }
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Trial* trial : trials) {
    const Signals& x = has_command ? trial->commanded : trial->displacement;
    scatter += x.transpose() * x;
  }
  return spread(scatter) < kDirectionSpread;
}

/// A channel stands at its extreme of the record for kFlatDuration, and that extreme is large for the
/// condition.
bool has_flat_extreme(const Eigen::VectorXd& force, double least, double sample_period) {
  const Eigen::Index limit = std::max<Eigen::Index>(6, rows_in(kFlatDuration, sample_period));
  for (const double extreme : {force.maxCoeff(), force.minCoeff()}) {
    if (std::abs(extreme) < least) continue;
    Eigen::Index run = 0;
    for (const double value : force) {
      run = std::abs(value - extreme) <= 1e-9 * std::abs(extreme) ? run + 1 : 0;
      if (run >= limit) return true;
    }
  }
  return false;
}

bool is_any_clipped(std::span<const Trial* const> trials) {
  if (std::ranges::any_of(trials, [](const Trial* trial) { return trial->is_clipped; })) return true;
  for (int axis = 0; axis < trials.front()->axes(); ++axis) {
    double largest = 0.0;
    for (const Trial* trial : trials)
      largest = std::max(largest, trial->force.col(axis).cwiseAbs().maxCoeff());
    if (largest == 0.0) continue;
    for (const Trial* trial : trials) {
      const Eigen::VectorXd moving = trial->force.col(axis).tail(trial->samples() - trial->onset);
      if (has_flat_extreme(moving, 0.5 * largest, trial->sample_period)) return true;
    }
  }
  return false;
}

}  // namespace

Diagnosis diagnose(std::span<const Trial* const> trials, const Options& options, double frequency) {
  Diagnosis diagnosis;
  if (trials.empty()) return diagnosis;
  const int axes = trials.front()->axes();
  const double sample_period = trials.front()->sample_period;
  diagnosis.force_lag = AxisVector::Zero(axes);
  diagnosis.is_force_clipped = is_any_clipped(trials);
  diagnosis.is_single_direction = axes == 2 && is_one_line(trials, options.window);
  if (std::ranges::any_of(trials, [](const Trial* trial) { return trial->is_continuous; })) {
    if (axes == 2) {
      Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
      for (const Trial* trial : trials) scatter += trial->force.transpose() * trial->force;
      diagnosis.is_force_collinear = spread(scatter) < kForceSpread;
    }
    return diagnosis;
  }
  if (diagnosis.is_single_direction || frequency <= 0.0) return diagnosis;

  const auto step = StateVariableStep::make(2.0 * frequency, 0.7, sample_period);
  const ConditionResponse response = response_of(trials, options.window, options.window + kLagScanned, step);
  if (axes == 2) {
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const Eigen::Index axis : {0, 1}) {
      const Eigen::MatrixXd force = response.mean(response.force, axis);
      scatter += force.transpose() * force;
    }
    diagnosis.is_force_collinear = spread(scatter) < kForceSpread;
    if (diagnosis.is_force_collinear) return diagnosis;
  }
  const auto lags = force_lags(response, frequency);
  diagnosis.is_lag_examined = true;
  for (std::size_t axis = 0; axis < lags.size(); ++axis) {
    diagnosis.force_lag[static_cast<Eigen::Index>(axis)] = lags[axis].time;
    diagnosis.is_force_shifted |= lags[axis].is_shifted;
    if (lags[axis].misfit_share < diagnosis.misfit_share) continue;
    diagnosis.misfit = lags[axis].misfit;
    diagnosis.misfit_share = lags[axis].misfit_share;
  }
  return diagnosis;
}

void take_tests(const refined::Estimate& tests, bool is_by_mean_motion, Diagnosis& diagnosis) {
  diagnosis.model_tests = &tests;
  diagnosis.is_by_mean_motion = is_by_mean_motion;
  diagnosis.is_force_shifted = false;  // they have a test of it
}

}  // namespace tonus::impedance
