#pragma once

#include <Eigen/Core>
#include <vector>

namespace tonus::refined {

/// A stationary vector autoregression (5), e(t) = sum A_i e(t-i) + w(t), cov w = S: the spectrum of what the
/// model leaves of the force.
struct ResidualProcess {
  std::vector<Eigen::MatrixXd> A;  ///< By lag from 1, axes x axes; none: white.
  Eigen::MatrixXd S;               ///< N2, axes x axes.
  Eigen::MatrixXd state;           ///< N2, covariance of [e(t); e(t-1); ...], as many as A has; white: empty.

  [[nodiscard]] Eigen::Index order() const { return static_cast<Eigen::Index>(A.size()); }
};

inline constexpr Eigen::Index kHighestOrder = 8;

/// The order that Akaike's criterion chooses for these residuals (each n x axes, of zero mean), at most
/// kHighestOrder.
[[nodiscard]] Eigen::Index chosen_order(const std::vector<Eigen::MatrixXd>& residuals);

/// Least squares over all trials, with one process for them. Where a pole lies outside a circle of 0.995, all
/// are shrunk towards 0 by one factor until none does.
[[nodiscard]] ResidualProcess fit_process(const std::vector<Eigen::MatrixXd>& residuals, Eigen::Index order);

/// Covariance (axes x axes, N2) of the process's mean over n samples.
[[nodiscard]] Eigen::MatrixXd covariance_of_mean(const ResidualProcess& process, Eigen::Index n);

}  // namespace tonus::refined
