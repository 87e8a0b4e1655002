#pragma once

#include <Eigen/Core>

#include "analysis_service/refined/weighted_fit.hpp"

namespace tonus::refined {

/// One standard deviation of a combination of the parameters and the degrees of freedom of its Student t.
struct Spread {
  double std = 0.0;
  double freedom = 0.0;
};

/// Covariance of theta with the trial as the independent unit (8): the sandwich of the scores Z_j' r_j with
/// the bias-reduced correction CR2, (I - H_jj)^-1/2, H_jj = Z_j (Z'Z)^-1 Z_j', and degrees of freedom after
/// Bell and McCaffrey: those of the variance that the correction would give if the whitened residuals were
/// white.
class TrialCovariance {
 public:
  explicit TrialCovariance(const WeightedFit& fit);

  /// Of vec(theta), column by column.
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return covariance_; }
  /// What the residual process alone says: s2 (Z'X)^-1 Z'Z (X'Z)^-1.
  [[nodiscard]] const Eigen::MatrixXd& model_covariance() const { return model_covariance_; }
  /// Variance of a whitened residual; 1 where the process is right.
  [[nodiscard]] double residual_variance() const { return residual_variance_; }
  /// Of weights' vec(theta).
  [[nodiscard]] Spread spread_of(const Eigen::VectorXd& weights) const;

 private:
  Eigen::MatrixXd covariance_;
  Eigen::MatrixXd model_covariance_;
  double residual_variance_ = 0.0;
  Eigen::MatrixXd to_root_;               // S^1/2 (Z'X)^-T: from weights to the space of the two below
  std::vector<Eigen::MatrixXd> shares_;   // T_j = S^-1/2 Z_j'Z_j S^-1/2
  std::vector<Eigen::MatrixXd> factors_;  // R_j = (I - T_j)^-1/2
};

}  // namespace tonus::refined
