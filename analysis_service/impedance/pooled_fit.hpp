#pragma once

#include <Eigen/Dense>
#include <limits>
#include <optional>
#include <vector>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "analysis_service/impedance/recursive_least_squares.hpp"

namespace tonus::impedance {

/// Condition number of the regressor with its columns scaled to unit length, from its factor R: the largest
/// over the smallest singular value. Infinite where a column is zero or R is not finite.
/// Defined for the sizes of with_sizes() (sized.hpp).
template <int kSize>
[[nodiscard]] double scaled_condition(const Eigen::Matrix<double, kSize, kSize>& R);

/// A cheap upper bound of scaled_condition, by Frobenius norms; at most kSize times as large.
template <int kSize>
[[nodiscard]] double condition_bound(const Eigen::Matrix<double, kSize, kSize>& R) {
  const Eigen::Matrix<double, 1, kSize> lengths = R.colwise().norm();
  if (!R.allFinite() || !(R.diagonal().cwiseAbs().minCoeff() > 0.0))
    return std::numeric_limits<double>::infinity();
  const Eigen::Matrix<double, kSize, kSize> scaled = R * lengths.cwiseInverse().asDiagonal();
  const Eigen::Matrix<double, kSize, kSize> inverse =
      scaled.template triangularView<Eigen::Upper>().solve(Eigen::Matrix<double, kSize, kSize>::Identity());
  return scaled.norm() * inverse.norm();
}

/// Theta = R^-1 Z.
template <int kSize, int kOutputs>
[[nodiscard]] Eigen::Matrix<double, kSize, kOutputs> solve(
    const RecursiveLeastSquares<kSize, kOutputs>& factor) {
  return factor.R().template triangularView<Eigen::Upper>().solve(factor.Z());
}

/// Numbers of the pooled fit of independent units (trials or blocks), each given by its factor: the solution,
/// its fit, and the leave-one-unit-out jackknife. With Theta_g the solution without unit g, G units and d_g =
/// Theta_g - Theta: covariance = (G-1)/G sum d_g d_g', which treats everything inside a unit as dependent;
/// intervals use Student's t with G - 1 degrees of freedom. X0 = -K^-1 c is taken through the same jackknife.
/// Fills the estimate's numbers; or leaves them empty and returns why.
/// Defined for the sizes of with_sizes() (sized.hpp).
template <int kSize, int kOutputs>
[[nodiscard]] std::optional<Reason> fit_pooled(
    const std::vector<RecursiveLeastSquares<kSize, kOutputs>>& units, double rank_margin, Estimate& estimate);

}  // namespace tonus::impedance
