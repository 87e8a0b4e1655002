#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "analysis_service/impedance/state_variable_filter.hpp"
#include "analysis_service/impedance/trial.hpp"

namespace tonus::impedance {

/// Mean of each trial's signal over `window` s from its onset, trials x axes. `signal` gives a Trial's
/// Signals.
[[nodiscard]] Eigen::MatrixXd means_over_window(std::span<const Trial* const> trials, double window,
                                                const Signals& (*signal)(const Trial&));

inline constexpr double kResponsePeriod =
    0.005;  ///< s, between rows of a response, or the trials' own if longer.

/// The step trials of one condition behind a filter (8), aligned at their onsets, and what they have in
/// common.
///
/// Law, at each time from the onset: a trial's signals are its mean displacement d_g (axes) times the
/// condition's response to a displacement of 1 m along each axis, plus what is its own (sensor noise,
/// voluntary force). With D the trials x axes of all d_g, the least-squares response is W times the trials'
/// signals, W = D^+; its error has the variance of what is the trials' own times diag(W W').
struct ConditionResponse {
  double sample_period = 0.0;           ///< s from row to row.
  Eigen::Index rest = 0;                ///< Rows before the onset.
  Eigen::MatrixXd displacements;        ///< D, m, trials x axes.
  Eigen::MatrixXd weights;              ///< W, 1/m, axes x trials.
  std::vector<Eigen::MatrixXd> states;  ///< Of each trial [x" x' x], rows x 3 axes.
  std::vector<Eigen::MatrixXd> force;   ///< Of each trial from its mean at rest, N, rows x axes.

  [[nodiscard]] Eigen::Index axes() const { return displacements.cols(); }
  [[nodiscard]] Eigen::Index rows() const { return force.front().rows(); }

  /// The response along `axis` in one of the above, `states` or `force`.
  [[nodiscard]] Eigen::MatrixXd mean(const std::vector<Eigen::MatrixXd>& signals, Eigen::Index axis) const;
};

/// `trials`: at least one, none continuous, each lasting for `window` s from its onset. `duration` (s) from
/// the onset is kept, at most; of fast sampling only every nth row, kResponsePeriod apart: what is behind the
/// filter is slow.
[[nodiscard]] ConditionResponse response_of(std::span<const Trial* const> trials, double window,
                                            double duration, const StateVariableStep& step);

}  // namespace tonus::impedance
