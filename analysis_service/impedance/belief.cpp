#include "analysis_service/impedance/belief.hpp"

#include <algorithm>
#include <cmath>

#include "analysis_service/statistics/distributions.hpp"

namespace tonus::impedance {

Combined combine(const Belief& estimate, const Belief& prior) {
  const Eigen::ArrayXd own = estimate.covariance.diagonal().array();
  const Eigen::ArrayXd before = prior.covariance.diagonal().array();
  const Eigen::VectorXd weight = (before / (own + before)).matrix();  // of the estimate
  const Eigen::VectorXd rest = (1.0 - weight.array()).matrix();
  Combined combined;
  combined.belief.value = weight.cwiseProduct(estimate.value) + rest.cwiseProduct(prior.value);
  combined.belief.covariance = weight.asDiagonal() * estimate.covariance * weight.asDiagonal();
  combined.belief.covariance += rest.asDiagonal() * prior.covariance * rest.asDiagonal();
  combined.std = combined.belief.covariance.diagonal().cwiseSqrt();
  combined.half.resize(combined.std.size());
  combined.belief.freedom = 1e9;
  for (Eigen::Index i = 0; i < combined.std.size(); ++i) {
    const double a = weight[i] * weight[i] * own[i];
    const double b = rest[i] * rest[i] * before[i];
    const double freedom =
        (a + b) * (a + b) / (a * a / std::max(1.0, estimate.freedom) + b * b / std::max(1.0, prior.freedom));
    combined.half[i] = statistics::student_t_factor(0.95, freedom) * combined.std[i];
    combined.belief.freedom = std::min(combined.belief.freedom, freedom);
    const double joint =
        std::hypot(statistics::student_t_factor(0.95, std::max(1.0, estimate.freedom)) * std::sqrt(own[i]),
                   statistics::student_t_factor(0.95, std::max(1.0, prior.freedom)) * std::sqrt(before[i]));
    combined.apart = std::max(combined.apart, std::abs(estimate.value[i] - prior.value[i]) / joint);
  }
  return combined;
}

Belief belief_of_many(const Eigen::MatrixXd& values_by_column) {
  const auto count = static_cast<double>(values_by_column.cols());
  Belief belief;
  belief.value = values_by_column.rowwise().mean();
  const Eigen::MatrixXd apart = values_by_column.colwise() - belief.value;
  belief.covariance = apart * apart.transpose() / (count - 1.0) * (1.0 + 1.0 / count);
  belief.freedom = count - 1.0;
  return belief;
}

}  // namespace tonus::impedance
