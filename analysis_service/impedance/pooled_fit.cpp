#include "analysis_service/impedance/pooled_fit.hpp"

#include "analysis_service/impedance/uncertainty.hpp"
#include "analysis_service/statistics/distributions.hpp"

namespace tonus::impedance {

template <int kSize>
double scaled_condition(const Eigen::Matrix<double, kSize, kSize>& R) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Eigen::Matrix<double, 1, kSize> lengths = R.colwise().norm();
  if (!R.allFinite() || !(lengths.minCoeff() > 0.0)) return kInfinite;
  const Eigen::Matrix<double, kSize, kSize> scaled = R * lengths.cwiseInverse().asDiagonal();
  const Eigen::Matrix<double, kSize, 1> values =
      Eigen::JacobiSVD<Eigen::Matrix<double, kSize, kSize>>(scaled).singularValues();
  return values[kSize - 1] > 0.0 ? values[0] / values[kSize - 1] : kInfinite;
}

template <int kSize, int kOutputs>
std::optional<Reason> fit_pooled(const std::vector<RecursiveLeastSquares<kSize, kOutputs>>& units,
                                 double rank_margin, Estimate& estimate) {
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
  Eigen::MatrixXd centre = Eigen::MatrixXd::Zero(kOutputs, kOutputs);
  Factor after;
  for (std::size_t g = count; g-- > 0;) {
    Factor others = before[g];
    others.merge(after);
    if (!(scaled_condition<kSize>(others.R()) * rank_margin < 1.0)) return Reason::kTooFewTrials;
    const Eigen::Matrix<double, kSize, kOutputs> theta_g = solve(others);
    const Eigen::Matrix<double, kElements, 1> d = (theta_g - theta).reshaped();
    covariance += d * d.transpose();
    const Eigen::VectorXd apart = flatten(parameters_from(theta_g, kOutputs)) - elements;
    variance += apart.cwiseAbs2();
    const Eigen::VectorXd shift = apart.tail(kOutputs);
    centre += shift * shift.transpose();
    after.merge(units[g]);
  }
  const double freedom = static_cast<double>(count - 1);
  const double share = freedom / static_cast<double>(count);
  const Eigen::VectorXd deviation = (share * variance).cwiseSqrt();
  const double factor = statistics::student_t_factor(0.95, freedom);
  estimate.value = value;
  estimate.std = unflatten(deviation, value);
  estimate.low = unflatten(elements - factor * deviation, value);
  estimate.high = unflatten(elements + factor * deviation, value);
  estimate.covariance = share * covariance;
  estimate.X0_covariance = share * centre;
  const auto spread_of = [&](const Eigen::VectorXd& weights) {
    return CombinationSpread{std::sqrt(weights.dot(estimate.covariance * weights)), freedom};
  };
  set_uncertainty_of_theta(estimate.covariance, spread_of, estimate);
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

template double scaled_condition<3>(const Eigen::Matrix<double, 3, 3>&);
template double scaled_condition<4>(const Eigen::Matrix<double, 4, 4>&);
template double scaled_condition<5>(const Eigen::Matrix<double, 5, 5>&);
template double scaled_condition<7>(const Eigen::Matrix<double, 7, 7>&);
template double scaled_condition<8>(const Eigen::Matrix<double, 8, 8>&);

template std::optional<Reason> fit_pooled(const std::vector<RecursiveLeastSquares<3, 1>>&, double, Estimate&);
template std::optional<Reason> fit_pooled(const std::vector<RecursiveLeastSquares<4, 1>>&, double, Estimate&);
template std::optional<Reason> fit_pooled(const std::vector<RecursiveLeastSquares<5, 2>>&, double, Estimate&);
template std::optional<Reason> fit_pooled(const std::vector<RecursiveLeastSquares<7, 2>>&, double, Estimate&);
template std::optional<Reason> fit_pooled(const std::vector<RecursiveLeastSquares<8, 2>>&, double, Estimate&);

}  // namespace tonus::impedance
