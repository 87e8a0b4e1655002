#include "analysis_service/impedance/diagnostics.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "analysis_service/impedance/state_variable_filter.hpp"

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

/// Mean of each trial's signal over the window, trials x axes.
template <typename Signal>
Eigen::MatrixXd means_over_window(std::span<const Trial* const> trials, double window, const Signal& signal) {
  Eigen::MatrixXd means(static_cast<Eigen::Index>(trials.size()), trials.front()->axes());
  for (std::size_t g = 0; g < trials.size(); ++g) {
    const Trial& trial = *trials[g];
    const Eigen::Index rows = std::min(rows_in(window, trial.sample_period), trial.samples() - trial.onset);
    means.row(static_cast<Eigen::Index>(g)) = mean_of_rows(signal(trial), trial.onset, rows).transpose();
  }
  return means;
}

bool is_one_line(std::span<const Trial* const> trials, double window) {
  const auto commanded = [](const Trial& trial) -> const Signals& { return trial.commanded; };
  const auto measured = [](const Trial& trial) -> const Signals& { return trial.displacement; };
  const bool has_command = std::ranges::all_of(
      trials, [](const Trial* trial) { return trial->commanded.rows() == trial->samples(); });
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

/// The condition's mean response to a displacement of 1 along each axis, aligned at the onset.
struct MeanResponse {
  Eigen::Index rest = 0;  ///< Rows before the onset.
  std::vector<Signals> displacement;
  std::vector<Signals> force;
};

MeanResponse mean_response(std::span<const Trial* const> trials, double window) {
  const Eigen::MatrixXd means = means_over_window(
      trials, window, [](const Trial& trial) -> const Signals& { return trial.displacement; });
  const Eigen::MatrixXd weights = means.completeOrthogonalDecomposition().pseudoInverse();  // axes x trials
  MeanResponse response;
  response.rest = trials.front()->onset;
  Eigen::Index moving = trials.front()->samples() - trials.front()->onset;
  for (const Trial* trial : trials) {
    response.rest = std::min(response.rest, trial->onset);
    moving = std::min(moving, trial->samples() - trial->onset);
  }
  const Eigen::Index rows = response.rest + moving;
  const int axes = trials.front()->axes();
  for (int i = 0; i < axes; ++i) {
    Signals x = Signals::Zero(rows, axes);
    Signals f = Signals::Zero(rows, axes);
    for (std::size_t g = 0; g < trials.size(); ++g) {
      const double weight = weights(i, static_cast<Eigen::Index>(g));
      const AxisVector bias = mean_of_rows(trials[g]->force, 0, trials[g]->onset);
      const Eigen::Index first = trials[g]->onset - response.rest;
      x += weight * trials[g]->displacement.middleRows(first, rows);
      f += weight * (trials[g]->force.middleRows(first, rows).rowwise() - bias.transpose());
    }
    response.displacement.push_back(std::move(x));
    response.force.push_back(std::move(f));
  }
  return response;
}

/// Columns [y" y' y] of each column of a signal behind the filter; `has_derivatives` false: y only.
Eigen::MatrixXd filtered(const Signals& signals, const StateVariableStep& step, bool has_derivatives) {
  const Eigen::Index axes = signals.cols();
  Eigen::MatrixXd states(signals.rows(), has_derivatives ? 3 * axes : axes);
  for (Eigen::Index axis = 0; axis < axes; ++axis) {
    StateVariableFilter<1> filter(step);
    for (Eigen::Index k = 0; k < signals.rows(); ++k) {
      filter.push(signals.col(axis).segment<1>(k).array());
      if (!has_derivatives) {
        states(k, axis) = filter.value()[0];
        continue;
      }
      states(k, axis) = filter.acceleration()[0];
      states(k, axes + axis) = filter.rate()[0];
      states(k, 2 * axes + axis) = filter.value()[0];
    }
  }
  return states;
}

struct Lag {
  double time = 0.0;
  double residual_ratio = 1.0;
};

/// Best shift of each force channel, from the residuals of model (3) at every shift of whole samples.
std::vector<Lag> scan_lags(const MeanResponse& response, double sample_period, double frequency) {
  const auto axes = static_cast<int>(response.force.size());
  const Eigen::Index reach = rows_in(kLagScanned, sample_period);
  const Eigen::Index before = std::min(response.rest - reach, rows_in(0.1, sample_period));
  const Eigen::Index rows_total = response.force.front().rows();
  const Eigen::Index after =
      std::min(rows_in(1.25 / frequency, sample_period), rows_total - response.rest - reach);
  const Eigen::Index columns = 3 * axes + 1;
  if (before < 1 || after < 4 * columns) return std::vector<Lag>(static_cast<std::size_t>(axes));

  const auto step = StateVariableStep::make(2.0 * frequency, 0.7, sample_period);
  const Eigen::Index first = response.rest - before;
  const Eigen::Index rows = before + after;
  Eigen::MatrixXd Phi(axes * rows, columns);
  std::vector<Eigen::MatrixXd> force;
  for (int i = 0; i < axes; ++i) {
    const auto n = static_cast<std::size_t>(i);
    Phi.block(i * rows, 0, rows, 3 * axes) =
        filtered(response.displacement[n], step, true).middleRows(first, rows);
    force.push_back(filtered(response.force[n], step, false));
  }
  Phi.rightCols(1).setOnes();
  const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(Phi).householderQ() *
                            Eigen::MatrixXd::Identity(axes * rows, columns);
  Eigen::MatrixXd residual(2 * reach + 1, axes);
  Eigen::MatrixXd F(axes * rows, axes);
  for (Eigen::Index lag = -reach; lag <= reach; ++lag) {
    for (int i = 0; i < axes; ++i) {
      F.middleRows(i * rows, rows) = force[static_cast<std::size_t>(i)].middleRows(first + lag, rows);
    }
    residual.row(reach + lag) = (F - Q * (Q.transpose() * F)).colwise().squaredNorm();
  }
  std::vector<Lag> lags;
  for (int axis = 0; axis < axes; ++axis) {
    Eigen::Index best = 0;
    const double least = residual.col(axis).minCoeff(&best);
    lags.push_back({static_cast<double>(best - reach) * sample_period,
                    least > 0.0 ? residual(reach, axis) / least : 1.0});
  }
  return lags;
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

  const MeanResponse response = mean_response(trials, options.window);
  if (axes == 2) {
    const auto step = StateVariableStep::make(2.0 * frequency, 0.7, sample_period);
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const Signals& force : response.force) {
      const Eigen::MatrixXd smooth = filtered(force, step, false);
      scatter += smooth.transpose() * smooth;
    }
    diagnosis.is_force_collinear = spread(scatter) < kForceSpread;
    if (diagnosis.is_force_collinear) return diagnosis;
  }
  const std::vector<Lag> lags = scan_lags(response, sample_period, frequency);
  for (int axis = 0; axis < axes; ++axis) {
    const Lag& lag = lags[static_cast<std::size_t>(axis)];
    diagnosis.force_lag[axis] = lag.time;
    if (std::abs(lag.time) > kLagTolerated && lag.residual_ratio > kLagResidualRatio) {
      diagnosis.is_force_shifted = true;
    }
  }
  return diagnosis;
}

}  // namespace tonus::impedance
