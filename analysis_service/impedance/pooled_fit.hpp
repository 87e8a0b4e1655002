#pragma once

#include <Eigen/Dense>
#include <limits>
#include <optional>
#include <vector>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "analysis_service/impedance/recursive_least_squares.hpp"
#include "analysis_service/impedance/student_t.hpp"

namespace tonus::impedance {

/// Condition number of the regressor with its columns scaled to unit length, from its factor R: the largest
/// over the smallest singular value. Infinite where a column is zero or R is not finite.
template <int kSize>
[[nodiscard]] double scaled_condition(const Eigen::Matrix<double, kSize, kSize>& R) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Eigen::Matrix<double, 1, kSize> lengths = R.colwise().norm();
  if (!R.allFinite() || !(lengths.minCoeff() > 0.0)) return kInfinite;
  const Eigen::Matrix<double, kSize, kSize> scaled = R * lengths.cwiseInverse().asDiagonal();
  const Eigen::Matrix<double, kSize, 1> values =
      Eigen::JacobiSVD<Eigen::Matrix<double, kSize, kSize>>(scaled).singularValues();
  return values[kSize - 1] > 0.0 ? values[0] / values[kSize - 1] : kInfinite;
}

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
template <int kSize, int kOutputs>
[[nodiscard]] std::optional<Reason> fit_pooled(
    const std::vector<RecursiveLeastSquares<kSize, kOutputs>>& units, double rank_margin,
    Estimate& estimate) {
  using Factor = RecursiveLeastSquares<kSize, kOutputs>;
  const std::size_t count = units.size();
  estimate.units = count;
  // before[g]: units 0 .. g-1, in order; so before[count] is all of them.
  std::vector<Factor> before(count + 1);
  for (std::size_t g = 0; g < count; ++g) {
    before[g + 1] = before[g];
    before[g + 1].merge(units[g]);
  }
  const Factor& all = before[count];
  estimate.samples = all.samples();
  estimate.condition_number = scaled_condition<kSize>(all.R());
  estimate.information = {all.R(), all.Z(), all.residual(), all.samples()};
  if (!(estimate.condition_number * rank_margin < 1.0)) return Reason::kRankDeficient;
  if (count < 2) return Reason::kTooFewTrials;

  const Eigen::Matrix<double, kSize, kOutputs> theta = solve(all);
  const Parameters value = parameters_from(theta, kOutputs);
  const Eigen::VectorXd elements = flatten(value);
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(elements.size());
  constexpr Eigen::Index kElements = Eigen::Index{kSize} * kOutputs;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kElements, kElements);
  Factor after;
  for (std::size_t g = count; g-- > 0;) {
    Factor others = before[g];
    others.merge(after);
    if (!(scaled_condition<kSize>(others.R()) * rank_margin < 1.0)) return Reason::kTooFewTrials;
    const Eigen::Matrix<double, kSize, kOutputs> theta_g = solve(others);
    const Eigen::Matrix<double, kElements, 1> d = (theta_g - theta).reshaped();
    covariance += d * d.transpose();
    variance += (flatten(parameters_from(theta_g, kOutputs)) - elements).cwiseAbs2();
    after.merge(units[g]);
  }
  const double freedom = static_cast<double>(count - 1);
  const double share = freedom / static_cast<double>(count);
  const Eigen::VectorXd deviation = (share * variance).cwiseSqrt();
  const double factor = student_t_factor(0.95, freedom);
  estimate.value = value;
  estimate.std = unflatten(deviation, value);
  estimate.low = unflatten(elements - factor * deviation, value);
  estimate.high = unflatten(elements + factor * deviation, value);
  estimate.covariance = share * covariance;
  estimate.sigma = (all.residual() / static_cast<double>(all.samples())).cwiseSqrt();  // (16)
  // Variation about the mean: the last column of the regressor is the constant, so that Z and R hold it too.
  const auto Z = all.Z();
  const Eigen::Matrix<double, kSize, 1> R_last = all.R().template rightCols<1>();
  const Eigen::Matrix<double, 1, kOutputs> squares = Z.colwise().squaredNorm();
  const Eigen::Matrix<double, 1, kOutputs> mean_part =
      (R_last.transpose() * Z).cwiseAbs2() / R_last.squaredNorm();
  estimate.explained.resize(kOutputs);
  for (int axis = 0; axis < kOutputs; ++axis) {
    const double variation = squares[axis] + all.residual()[axis] - mean_part[axis];
    estimate.explained[axis] = variation > 0.0 ? 1.0 - all.residual()[axis] / variation : 0.0;
  }
  return std::nullopt;
}

}  // namespace tonus::impedance
