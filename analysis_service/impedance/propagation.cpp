#include "analysis_service/impedance/propagation.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "analysis_service/statistics/distributions.hpp"

namespace tonus::impedance {
namespace {

constexpr Eigen::Index kElements = 12;
constexpr double kStep = 0.1;  // of an element's standard error

double& element(CartesianImpedance& impedance, Eigen::Index i) {
  Eigen::Matrix2d& matrix = i < 4 ? impedance.M : i < 8 ? impedance.B : impedance.K;
  return matrix((i % 4) / 2, i % 2);
}

/// Slope of the numbers with element `i` of posture `p`; none where they cannot be computed.
std::optional<Eigen::VectorXd> slope(std::vector<PostureImpedance>& values, std::size_t p, Eigen::Index i,
                                     double step, const FromPostures& compute) {
  double& value = element(values[p].impedance, i);
  const double middle = value;
  value = middle + step;
  const auto above = compute(values);
  value = middle - step;
  const auto below = compute(values);
  value = middle;
  if (!above || !below) return std::nullopt;
  return Eigen::VectorXd((*above - *below) / (2.0 * step));
}

CartesianImpedance less(const CartesianImpedance& value, const CartesianImpedance& bias) {
  return {value.M - bias.M, value.B - bias.B, value.K - bias.K};
}

}  // namespace

std::optional<UncertainPosture> uncertain_posture(const Eigen::Vector2d& position, const Estimate& estimate) {
  if (estimate.axes != 2 || estimate.model != Model::kLinear || estimate.status == Status::kUndetermined)
    return std::nullopt;
  if (estimate.covariance.rows() != 14) return std::nullopt;
  std::vector<Eigen::Index> places;
  for (const Eigen::Index first : {0, 2, 4}) {
    for (const Eigen::Index row : {0, 1}) {
      for (const Eigen::Index column : {0, 1}) places.push_back(row * 7 + first + column);
    }
  }
  UncertainPosture posture;
  posture.value = {position, {estimate.value.M, estimate.value.B, estimate.value.K}};
  posture.covariance = estimate.covariance(places, places);
  posture.freedom = std::min(
      {estimate.uncertainty.M.freedom, estimate.uncertainty.B.freedom, estimate.uncertainty.K.freedom});
  if (estimate.uncertainty.M.known_bias.size() > 0)
    posture.bias = {estimate.uncertainty.M.known_bias, estimate.uncertainty.B.known_bias,
                    estimate.uncertainty.K.known_bias};
  return posture;
}

std::vector<Interval> propagate(std::span<const UncertainPosture> postures, const FromPostures& compute) {
  std::vector<PostureImpedance> values;
  std::vector<PostureImpedance> unbiased;
  for (const UncertainPosture& posture : postures) {
    values.push_back(posture.value);
    unbiased.push_back({posture.value.position, less(posture.value.impedance, posture.bias)});
  }
  const auto middle = compute(values);
  const auto corrected = compute(unbiased);
  if (!middle || !corrected) return {};
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(middle->size());
  Eigen::VectorXd below = variance;  // of Welch and Satterthwaite
  for (std::size_t p = 0; p < postures.size(); ++p) {
    Eigen::MatrixXd G(middle->size(), kElements);
    for (Eigen::Index i = 0; i < kElements; ++i) {
      const double step = kStep * std::sqrt(postures[p].covariance(i, i));
      if (!(step > 0.0)) {
        G.col(i).setZero();
        continue;
      }
      const auto one = slope(values, p, i, step, compute);
      if (!one) return {};
      G.col(i) = *one;
    }
    const Eigen::VectorXd own = (G * postures[p].covariance * G.transpose()).diagonal();
    variance += own;
    below += own.cwiseAbs2() / std::max(1.0, postures[p].freedom);
  }
  std::vector<Interval> intervals;
  for (Eigen::Index k = 0; k < middle->size(); ++k) {
    const double freedom = below[k] > 0.0 ? variance[k] * variance[k] / below[k] : 1.0;
    const double half = statistics::student_t_factor(0.95, freedom) * std::sqrt(variance[k]);
    intervals.push_back(
        {std::min((*middle)[k], (*corrected)[k]) - half, std::max((*middle)[k], (*corrected)[k]) + half});
  }
  return intervals;
}

}  // namespace tonus::impedance
