#include "analysis_service/refined/trial_covariance.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace tonus::refined {
namespace {

// A trial that alone determines a combination of the parameters leaves nothing to judge it by.
constexpr double kLeastShareLeft = 1e-3;

}  // namespace

TrialCovariance::TrialCovariance(const WeightedFit& fit) {
  const Eigen::Index size = fit.ZX.rows();
  const auto theta = fit.theta.reshaped();
  std::vector<Eigen::MatrixXd> ZZ;
  std::vector<Eigen::VectorXd> scores;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
  double squares = 0.0;
  Eigen::Index rows = 0;
  for (std::size_t j = 0; j < fit.Z.size(); ++j) {
    const Eigen::VectorXd r = fit.y[j] - fit.X[j] * theta;
    ZZ.emplace_back(fit.Z[j].transpose() * fit.Z[j]);
    scores.emplace_back(fit.Z[j].transpose() * r);
    sum += ZZ.back();
    squares += r.squaredNorm();
    rows += r.size();
  }
  residual_variance_ = squares / static_cast<double>(rows - size);
  // Columns scaled to one size, so that roots and inverses lose no digits to the units.
  const Eigen::VectorXd scale = sum.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd S = scale.asDiagonal() * sum * scale.asDiagonal();
  const Eigen::MatrixXd G = scale.asDiagonal() * fit.ZX * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(S);
  const Eigen::MatrixXd root = modes.operatorSqrt();
  const Eigen::MatrixXd inverse_root = modes.operatorInverseSqrt();
  to_root_ = root * G.transpose().partialPivLu().solve(Eigen::MatrixXd(scale.asDiagonal()));

  Eigen::MatrixXd deviations(size, static_cast<Eigen::Index>(ZZ.size()));
  for (std::size_t j = 0; j < ZZ.size(); ++j) {
    const Eigen::MatrixXd scaled = scale.asDiagonal() * ZZ[j] * scale.asDiagonal();
    shares_.emplace_back(inverse_root * scaled * inverse_root);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> left(Eigen::MatrixXd::Identity(size, size) -
                                                              shares_.back());
    factors_.emplace_back(
        left.eigenvectors() *
        left.eigenvalues().cwiseMax(kLeastShareLeft).cwiseSqrt().cwiseInverse().asDiagonal() *
        left.eigenvectors().transpose());
    const Eigen::VectorXd score = inverse_root * scale.cwiseProduct(scores[j]);
    deviations.col(static_cast<Eigen::Index>(j)) = to_root_.transpose() * (factors_.back() * score);
  }
  covariance_ = deviations * deviations.transpose();
  model_covariance_ = residual_variance_ * to_root_.transpose() * to_root_;
}

Spread TrialCovariance::spread_of(const Eigen::VectorXd& weights) const {
  const Eigen::VectorXd a = to_root_ * weights;
  double trace = 0.0;
  double squares = 0.0;
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(a.size(), a.size());
  // Covariance O of the trials' contributions: O_ij = d_i (i = j) - b_i'b_j.
  for (std::size_t j = 0; j < shares_.size(); ++j) {
    const Eigen::VectorXd adjusted = factors_[j] * a;
    const Eigen::VectorXd b = shares_[j] * adjusted;
    const double d = b.dot(adjusted);
    const double own = b.squaredNorm();
    trace += d - own;
    squares += (d - own) * (d - own) - own * own;
    products.noalias() += b * b.transpose();
  }
  squares += products.squaredNorm();
  return {std::sqrt(weights.dot(covariance_ * weights)), trace * trace / squares};
}

}  // namespace tonus::refined
