#include "analysis_service/impedance/condition_response.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tonus::impedance {
namespace {

using Filter = StateVariableFilter<kMaxAxes>;
using Values = Eigen::Array<double, kMaxAxes, 1>;

/// Row k without `offset`; a missing axis is zero.
Values values_of(const Signals& signals, Eigen::Index k, const AxisVector& offset) {
  Values values = Values::Zero();
  for (Eigen::Index axis = 0; axis < signals.cols(); ++axis) values[axis] = signals(k, axis) - offset[axis];
  return values;
}

/// Which rows of a trial are filtered, and which of these are kept: each `stride`th from `skipped` on.
struct Rows {
  Eigen::Index first = 0;
  Eigen::Index count = 0;
  Eigen::Index stride = 1;
  Eigen::Index skipped = 0;

  [[nodiscard]] Eigen::Index kept() const { return (count - skipped + stride - 1) / stride; }
};

/// Filters the rows and hands keep(i, filter) each one that is kept.
template <typename Keep>
void filter_rows(const Signals& signals, const AxisVector& offset, const Rows& rows,
                 const StateVariableStep& step, const Keep& keep) {
  Filter filter(step);
  for (Eigen::Index k = 0; k < rows.count; ++k) {
    filter.push(values_of(signals, rows.first + k, offset));
    const Eigen::Index since = k - rows.skipped;
    if (since >= 0 && since % rows.stride == 0) keep(since / rows.stride, filter);
  }
}

Eigen::MatrixXd states_of(const Signals& displacement, const Rows& rows, const StateVariableStep& step) {
  const Eigen::Index axes = displacement.cols();
  Eigen::MatrixXd states(rows.kept(), 3 * axes);
  filter_rows(displacement, AxisVector::Zero(axes), rows, step, [&](Eigen::Index i, const Filter& filter) {
    states.row(i) << filter.acceleration().head(axes).transpose(), filter.rate().head(axes).transpose(),
        filter.value().head(axes).transpose();
  });
  return states;
}

Eigen::MatrixXd force_of(const Trial& trial, const Rows& rows, const StateVariableStep& step) {
  Eigen::MatrixXd force(rows.kept(), trial.axes());
  filter_rows(trial.force, mean_of_rows(trial.force, 0, trial.onset), rows, step,
              [&](Eigen::Index i, const Filter& filter) {
                force.row(i) = filter.value().head(trial.axes()).transpose();
              });
  return force;
}

}  // namespace

Eigen::MatrixXd means_over_window(std::span<const Trial* const> trials, double window,
                                  const Signals& (*signal)(const Trial&)) {
  Eigen::MatrixXd means(static_cast<Eigen::Index>(trials.size()), trials.front()->axes());
  for (std::size_t g = 0; g < trials.size(); ++g) {
    const Trial& trial = *trials[g];
    const auto rows =
        std::min<Eigen::Index>(std::llround(window / trial.sample_period), trial.samples() - trial.onset);
    means.row(static_cast<Eigen::Index>(g)) = mean_of_rows(signal(trial), trial.onset, rows).transpose();
  }
  return means;
}

Eigen::MatrixXd ConditionResponse::mean(const std::vector<Eigen::MatrixXd>& signals,
                                        Eigen::Index axis) const {
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(signals.front().rows(), signals.front().cols());
  for (std::size_t g = 0; g < signals.size(); ++g)
    mean += weights(axis, static_cast<Eigen::Index>(g)) * signals[g];
  return mean;
}

ConditionResponse response_of(std::span<const Trial* const> trials, double window, double duration,
                              const StateVariableStep& step) {
  ConditionResponse response;
  response.displacements = means_over_window(
      trials, window, [](const Trial& trial) -> const Signals& { return trial.displacement; });
  response.weights = response.displacements.completeOrthogonalDecomposition().pseudoInverse();
  const double sample_period = trials.front()->sample_period;
  Eigen::Index rest = trials.front()->onset;
  Eigen::Index moving = std::llround(duration / sample_period);
  for (const Trial* trial : trials) {
    rest = std::min(rest, trial->onset);
    moving = std::min(moving, trial->samples() - trial->onset);
  }
  Rows rows;
  rows.count = rest + moving;
  rows.stride = std::max<Eigen::Index>(1, std::llround(kResponsePeriod / sample_period));
  rows.skipped = rest % rows.stride;
  response.sample_period = static_cast<double>(rows.stride) * sample_period;
  response.rest = rest / rows.stride;
  for (const Trial* trial : trials) {
    rows.first = trial->onset - rest;
    response.states.push_back(states_of(trial->displacement, rows, step));
    response.force.push_back(force_of(*trial, rows, step));
  }
  return response;
}

}  // namespace tonus::impedance
