#include "analysis_service/refined/alternatives.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

#include "analysis_service/spectral/statistics.hpp"

namespace tonus::refined {
namespace {

constexpr double kReflexDelay = 0.040;  // s
constexpr double kSlow = 0.05;          // Of the largest speed, at which friction has half its force.

double chance_beyond(double squares, double freedom) {
  if (!std::isfinite(squares) || !(freedom > 0.0)) return 1.0;
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(freedom), std::max(0.0, squares)));
}

Eigen::MatrixXd rate_of(const Eigen::MatrixXd& x, double sample_period) {
  const Eigen::Index rows = x.rows();
  Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(rows, x.cols());
  if (rows > 2)
    rate.middleRows(1, rows - 2) = (x.bottomRows(rows - 2) - x.topRows(rows - 2)) / (2.0 * sample_period);
  return rate;
}

Eigen::MatrixXd term_of(Alternative alternative, const Eigen::MatrixXd& x, double sample_period) {
  const Eigen::MatrixXd rate = rate_of(x, sample_period);
  switch (alternative) {
    case Alternative::kReflex: {
      const Eigen::Index late = std::min<Eigen::Index>(std::llround(kReflexDelay / sample_period), x.rows());
      Eigen::MatrixXd delayed = Eigen::MatrixXd::Zero(x.rows(), x.cols());
      delayed.bottomRows(x.rows() - late) = rate.topRows(x.rows() - late);
      return delayed;
    }
    case Alternative::kHardening:
      return x.rowwise().squaredNorm().asDiagonal() * x;
    case Alternative::kFriction:
      break;
  }
  const Eigen::VectorXd speed = rate.rowwise().norm();
  const Eigen::VectorXd part = (speed.array() + kSlow * speed.maxCoeff() + 1e-12).inverse();
  return part.asDiagonal() * rate;
}

AlternativeTest test_one(Alternative alternative, const WeightedFit& fit, const TrialCovariance& covariance,
                         const std::vector<Eigen::MatrixXd>& terms, const WeakForm& weak) {
  const Eigen::Index size = fit.ZX.rows();
  const Eigen::Index axes = terms.front().cols();
  const Eigen::Index extra = axes * axes;
  double largest = 0.0;
  for (const auto& term : terms) largest = std::max(largest, term.cwiseAbs().maxCoeff());
  if (!(largest > 0.0)) return {alternative, 1.0, 0.0};
  Eigen::MatrixXd G(size + extra, size + extra);
  Eigen::MatrixXd ZZ = Eigen::MatrixXd::Zero(size + extra, size + extra);
  Eigen::VectorXd Zy = Eigen::VectorXd::Zero(size + extra);
  G.setZero();
  for (std::size_t j = 0; j < terms.size(); ++j) {
    Eigen::MatrixXd Z(fit.Z[j].rows(), size + extra);
    Z << fit.Z[j], fit.whitener.design(weak.apply(0, terms[j] / largest));
    Eigen::MatrixXd X = Z;
    X.leftCols(size) = fit.X[j];
    G.noalias() += Z.transpose() * X;
    ZZ.noalias() += Z.transpose() * Z;
    Zy.noalias() += Z.transpose() * fit.y[j];
  }
  const Eigen::VectorXd scale = ZZ.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd inverse = (scale.asDiagonal() * G * scale.asDiagonal()).inverse();
  const Eigen::VectorXd solution = scale.cwiseProduct(inverse * scale.cwiseProduct(Zy));
  const Eigen::MatrixXd V =
      covariance.residual_variance() * (scale.asDiagonal() * inverse * scale.asDiagonal() * ZZ *
                                        scale.asDiagonal() * inverse.transpose() * scale.asDiagonal());
  const Eigen::VectorXd b = solution.tail(extra);
  AlternativeTest test;
  test.alternative = alternative;
  test.p =
      chance_beyond(b.dot(V.bottomRightCorner(extra, extra).ldlt().solve(b)), static_cast<double>(extra));
  const Eigen::Index q = size / axes;
  for (Eigen::Index i = 0; i < size; ++i) {
    if (i % q == q - 1) continue;  // the offset
    const Spread spread = covariance.spread_of(Eigen::VectorXd::Unit(size, i));
    const double half = spectral::student_t_quantile(0.975, spread.freedom) * spread.std;
    test.effect = std::max(test.effect, std::abs(solution[i] - fit.theta.reshaped()[i]) / half);
  }
  return test;
}

}  // namespace

std::vector<AlternativeTest> test_alternatives(const WeightedFit& fit, const TrialCovariance& covariance,
                                               const std::vector<Eigen::MatrixXd>& predicted,
                                               const WeakForm& weak, double sample_period) {
  std::vector<AlternativeTest> tests;
  for (const Alternative alternative :
       {Alternative::kReflex, Alternative::kHardening, Alternative::kFriction}) {
    std::vector<Eigen::MatrixXd> terms;
    for (const Eigen::MatrixXd& x : predicted) terms.push_back(term_of(alternative, x, sample_period));
    tests.push_back(test_one(alternative, fit, covariance, terms, weak));
  }
  return tests;
}

MisfitTest test_misfit(const WeightedFit& fit, const TrialCovariance& covariance,
                       const std::vector<TrialRows>& trials, const Eigen::MatrixXd& weights) {
  const Eigen::Index axes = weights.cols();
  // W L' with L L' = U'U = (W'W)^-1 has orthonormal columns, so that noise of the trials stays as it is.
  const Eigen::MatrixXd L = (weights.transpose() * weights).inverse().llt().matrixL();
  const Eigen::MatrixXd orthonormal = weights * L;
  const auto theta = fit.theta.reshaped();
  double squares = 0.0;
  double misfit = 0.0;
  double response = 0.0;
  const Eigen::MatrixXd WW = weights.transpose() * weights;
  for (Eigen::Index b = 0; b < axes; ++b) {
    Eigen::VectorXd whitened = Eigen::VectorXd::Zero(fit.y.front().size());
    Eigen::MatrixXd residual = Eigen::MatrixXd::Zero(trials.front().force.rows(), axes);
    Eigen::MatrixXd force = residual;
    double noise = 0.0;
    for (std::size_t j = 0; j < trials.size(); ++j) {
      const auto row = static_cast<Eigen::Index>(j);
      whitened += orthonormal(row, b) * (fit.y[j] - fit.X[j] * theta);
      residual += weights(row, b) * fit.residuals[j];
      force += weights(row, b) * trials[j].force;
      noise += weights(row, b) * weights(row, b) * fit.residuals[j].squaredNorm();
    }
    squares += whitened.squaredNorm();
    misfit += residual.squaredNorm() - noise;
    response += force.squaredNorm();
  }
  const auto freedom = static_cast<double>(axes * fit.y.front().size() - 3 * axes * axes);
  MisfitTest test;
  test.p = chance_beyond(squares / covariance.residual_variance(), freedom);
  test.share = response > 0.0 ? std::sqrt(std::max(0.0, misfit) / response) : 0.0;
  return test;
}

}  // namespace tonus::refined
