#include "analysis_service/refined/alternatives.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "analysis_service/statistics/distributions.hpp"

namespace tonus::refined {
namespace {

constexpr double kReflexDelay = 0.040;  // s
constexpr double kSlow = 0.05;          // Of the largest speed, at which friction has half its force.
constexpr double kNear = 0.1;  // Of the largest displacement, at which a slack has taken half of its own.

double chance_beyond(double squares, double freedom) {
  if (!std::isfinite(squares) || !(freedom > 0.0)) return 1.0;
  return statistics::chi_squared_tail(std::max(0.0, squares), freedom);
}

/// Of Fisher's F.
double chance_beyond_ratio(double ratio, double above, double below) {
  if (!std::isfinite(ratio)) return 0.0;
  return statistics::fisher_tail(std::max(0.0, ratio), above, below);
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
    case Alternative::kSlack: {
      const Eigen::VectorXd distance = x.rowwise().norm();
      return (distance.array() + kNear * distance.maxCoeff() + 1e-12).inverse().matrix().asDiagonal() * x;
    }
    case Alternative::kFriction:
      break;
  }
  const Eigen::VectorXd speed = rate.rowwise().norm();
  const Eigen::VectorXd part = (speed.array() + kSlow * speed.maxCoeff() + 1e-12).inverse();
  return part.asDiagonal() * rate;
}

/// The fit with more columns, which are their own instruments.
struct Extended {
  Eigen::VectorXd solution;  // vec(theta), then the columns' coefficients
  Eigen::VectorXd b;         // the latter
  Eigen::MatrixXd V;         // their covariance by the residual process
  double p = 1.0;            // of b = 0
  double effect = 0.0;       // largest change of theta, in 95 % half-widths
  double share = 0.0;        // the same, of the largest element of its matrix
};

/// 95 % half-widths of vec(theta); 0 for the offsets, which are not asked for.
Eigen::VectorXd half_widths(const WeightedFit& fit, const TrialCovariance& covariance) {
  const Eigen::Index size = fit.theta.size();
  const Eigen::Index q = fit.theta.rows();
  Eigen::VectorXd halves = Eigen::VectorXd::Zero(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    if (i % q == q - 1) continue;
    const Spread spread = covariance.spread_of(Eigen::VectorXd::Unit(size, i));
    halves[i] = statistics::student_t_quantile(0.975, spread.freedom) * spread.std;
  }
  return halves;
}

/// `columns`: whitened, of each trial.
Extended extend(const WeightedFit& fit, const TrialCovariance& covariance, const Eigen::VectorXd& halves,
                const std::vector<Eigen::MatrixXd>& columns) {
  const Eigen::Index size = fit.ZX.rows();
  const Eigen::Index extra = columns.front().cols();
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(size + extra, size + extra);
  Eigen::MatrixXd ZZ = G;
  Eigen::VectorXd Zy = Eigen::VectorXd::Zero(size + extra);
  for (std::size_t j = 0; j < columns.size(); ++j) {
    Eigen::MatrixXd Z(fit.Z[j].rows(), size + extra);
    Z << fit.Z[j], columns[j];
    Eigen::MatrixXd X = Z;
    X.leftCols(size) = fit.X[j];
    G.noalias() += Z.transpose() * X;
    ZZ.noalias() += Z.transpose() * Z;
    Zy.noalias() += Z.transpose() * fit.y[j];
  }
  const Eigen::VectorXd scale = ZZ.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd inverse = (scale.asDiagonal() * G * scale.asDiagonal()).inverse();
  const Eigen::MatrixXd V =
      covariance.residual_variance() * (scale.asDiagonal() * inverse * scale.asDiagonal() * ZZ *
                                        scale.asDiagonal() * inverse.transpose() * scale.asDiagonal());
  Extended extended;
  extended.solution = scale.cwiseProduct(inverse * scale.cwiseProduct(Zy));
  extended.b = extended.solution.tail(extra);
  extended.V = V.bottomRightCorner(extra, extra);
  extended.p = chance_beyond(extended.b.dot(extended.V.ldlt().solve(extended.b)), static_cast<double>(extra));
  const Eigen::Index axes = fit.theta.cols();
  for (Eigen::Index i = 0; i < size; ++i) {
    const Eigen::Index row = i % fit.theta.rows();
    if (row == fit.theta.rows() - 1) continue;  // the offset
    const double change = std::abs(extended.solution[i] - fit.theta.reshaped()[i]);
    const double largest = fit.theta.middleRows(row / axes * axes, axes).cwiseAbs().maxCoeff();
    if (halves[i] > 0.0) extended.effect = std::max(extended.effect, change / halves[i]);
    if (largest > 0.0) extended.share = std::max(extended.share, change / largest);
  }
  return extended;
}

AlternativeTest test_one(Alternative alternative, const WeightedFit& fit, const TrialCovariance& covariance,
                         const Eigen::VectorXd& halves, const std::vector<Eigen::MatrixXd>& terms,
                         const WeakForm& weak) {
  double largest = 0.0;
  for (const auto& term : terms) largest = std::max(largest, term.cwiseAbs().maxCoeff());
  if (!(largest > 0.0)) return {alternative, 1.0, 0.0, 0.0, {}};
  std::vector<Eigen::MatrixXd> columns;
  columns.reserve(terms.size());
  for (const auto& term : terms) columns.push_back(fit.whitener.design(weak.apply(0, term / largest)));
  const Extended extended = extend(fit, covariance, halves, columns);
  const Eigen::Index size = fit.theta.size();
  const Eigen::Index axes = fit.theta.cols();
  AlternativeTest test{alternative, extended.p, extended.effect, extended.share,
                       extended.solution.head(size).reshaped(fit.theta.rows(), axes) - fit.theta};
  if (alternative == Alternative::kReflex) {  // b x'(t - d) = b x' - d b x" + ...
    const Eigen::MatrixXd b = extended.b.reshaped(axes, axes) / largest;
    test.change.topRows(axes) -= kReflexDelay * b;
    test.change.middleRows(axes, axes) += b;
  }
  return test;
}

/// Sums of squares of trials' residuals (rows x trials): of their means along the command, and what is left.
struct Analysis {
  double along = 0.0;
  double about = 0.0;
  Eigen::MatrixXd left;
};

Analysis analyse(const Eigen::MatrixXd& residuals, const Eigen::MatrixXd& orthonormal) {
  const Eigen::MatrixXd along = residuals * orthonormal;
  Analysis found{along.squaredNorm(), 0.0, residuals - along * orthonormal.transpose()};
  found.about = found.left.squaredNorm();
  return found;
}

/// Squares that the fit of theta takes from trials whose residuals are these.
double absorbed(const WeightedFit& fit, const Eigen::MatrixXd& residuals) {
  const Eigen::Index size = fit.ZX.rows();
  Eigen::MatrixXd ZZ = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd scores(size, residuals.cols());
  for (Eigen::Index j = 0; j < residuals.cols(); ++j) {
    const Eigen::MatrixXd& Z = fit.Z[static_cast<std::size_t>(j)];
    ZZ.noalias() += Z.transpose() * Z;
    scores.col(j) = Z.transpose() * residuals.col(j);
  }
  const Eigen::VectorXd scale = ZZ.diagonal().cwiseSqrt().cwiseInverse();
  ZZ = (scale.asDiagonal() * ZZ * scale.asDiagonal()).eval();
  scores = (scale.asDiagonal() * scores).eval();
  return scores.cwiseProduct(ZZ.ldlt().solve(scores)).sum();
}

/// How many directions the noise of the means along the command has, (tr C)^2 / tr C^2, from what trials j
/// and k have in common beside those means. With P = I - O O',
///     E (r_j' r_k)^2 = P_jk^2 (tr C)^2 + (P_jj P_kk + P_jk^2) tr C^2.
/// Encoder steps make C that of a trial's direction: pairs count by what they add to the variance, (O
/// O')_jk^2. Few trials have few such pairs, so that all pairs, alike, are asked as well, and the smaller
/// number counts.
double directions_of(const Analysis& found, const Eigen::MatrixXd& orthonormal) {
  const Eigen::Index count = orthonormal.rows();
  const Eigen::MatrixXd H = orthonormal * orthonormal.transpose();
  const Eigen::MatrixXd P = Eigen::MatrixXd::Identity(count, count) - H;
  const Eigen::MatrixXd products = found.left.transpose() * found.left;
  const double noise = found.about / static_cast<double>(count - orthonormal.cols());  // tr C
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  Eigen::Vector2d weights = Eigen::Vector2d::Zero();
  for (Eigen::Index j = 0; j < count; ++j) {
    for (Eigen::Index k = 0; k < j; ++k) {
      const Eigen::Vector2d weight(H(j, k) * H(j, k), 1.0);
      const double common = P(j, k) * P(j, k);
      squares += weight * (products(j, k) * products(j, k) - common * noise * noise);
      weights += weight * (P(j, j) * P(k, k) + common);
    }
  }
  const double largest = squares.cwiseQuotient(weights).maxCoeff();  // tr C^2
  const auto most = static_cast<double>(found.left.rows());
  return largest * most > noise * noise ? std::max(1.0, noise * noise / largest) : most;
}

/// (11) of the whitened residuals, rows x trials.
double chance_of_misfit(const WeightedFit& fit, const Eigen::MatrixXd& residuals,
                        const Eigen::MatrixXd& orthonormal) {
  const auto axes = static_cast<double>(orthonormal.cols());
  const auto count = static_cast<double>(residuals.cols());
  const double freedom = count - axes;
  if (!(freedom > 1.0)) return 1.0;
  const Analysis found = analyse(residuals, orthonormal);
  const double noise = found.about / freedom;
  const double expected = axes * noise - absorbed(fit, found.left) * count / freedom;
  if (!(expected > 0.0)) return 1.0;
  const double directions = directions_of(found, orthonormal);
  return chance_beyond_ratio(found.along / expected, expected / noise * directions, freedom * directions);
}

}  // namespace

std::vector<AlternativeTest> test_alternatives(const WeightedFit& fit, const TrialCovariance& covariance,
                                               const std::vector<Eigen::MatrixXd>& predicted,
                                               const WeakForm& weak, double sample_period) {
  std::vector<AlternativeTest> tests;
  const Eigen::VectorXd halves = half_widths(fit, covariance);
  for (const Alternative alternative :
       {Alternative::kReflex, Alternative::kHardening, Alternative::kFriction, Alternative::kSlack}) {
    std::vector<Eigen::MatrixXd> terms;
    terms.reserve(predicted.size());
    for (const Eigen::MatrixXd& x : predicted) terms.push_back(term_of(alternative, x, sample_period));
    tests.push_back(test_one(alternative, fit, covariance, halves, terms, weak));
  }
  return tests;
}

LagTest test_lag(const WeightedFit& fit, const TrialCovariance& covariance,
                 const std::vector<Eigen::MatrixXd>& predicted, const WeakForm& weak, double sample_period) {
  const Eigen::Index axes = fit.theta.cols();
  std::vector<Eigen::MatrixXd> columns;
  for (const Eigen::MatrixXd& x : predicted) {
    const Eigen::MatrixXd rate = rate_of(x, sample_period);
    Eigen::MatrixXd phi(weak.size(), 3 * axes);
    phi << weak.apply(2, rate), weak.apply(1, rate), weak.apply(0, rate);
    const Eigen::MatrixXd designed = fit.whitener.design(-phi * fit.theta.topRows(3 * axes));
    Eigen::MatrixXd own(designed.rows(), axes);  // the force of each axis is late by itself
    for (Eigen::Index i = 0; i < axes; ++i) own.col(i) = designed.col(i * axes + i);
    columns.push_back(std::move(own));
  }
  const Extended extended = extend(fit, covariance, half_widths(fit, covariance), columns);
  return {extended.p,      extended.b,     extended.V.diagonal().cwiseMax(0.0).cwiseSqrt(),
          extended.effect, extended.share, sample_period};
}

MisfitTest test_misfit(const WeightedFit& fit, const std::vector<TrialRows>& trials,
                       const Eigen::MatrixXd& weights) {
  const Eigen::Index axes = weights.cols();
  const auto count = static_cast<Eigen::Index>(trials.size());
  // W L with L L' = U'U = (W'W)^-1 has orthonormal columns, so that noise of the trials stays as it is.
  const Eigen::MatrixXd L = (weights.transpose() * weights).inverse().llt().matrixL();
  const Eigen::MatrixXd orthonormal = weights * L;
  const auto theta = fit.theta.reshaped();
  Eigen::MatrixXd whitened(fit.y.front().size(), count);
  Eigen::MatrixXd residuals(trials.front().force.size(), count);
  Eigen::MatrixXd forces(residuals.rows(), count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto at = static_cast<std::size_t>(j);
    whitened.col(j) = fit.y[at] - fit.X[at] * theta;
    residuals.col(j) = fit.residuals[at].reshaped();
    forces.col(j) = trials[at].force.reshaped();
  }
  MisfitTest test;
  const auto freedom = static_cast<double>(count - axes);
  test.p = chance_of_misfit(fit, whitened, orthonormal);
  const Analysis plain = analyse(residuals, orthonormal);
  const Eigen::MatrixXd along = residuals * orthonormal;
  const Eigen::MatrixXd response = forces * orthonormal;
  const Eigen::Index n = trials.front().force.rows();
  double misfit = 0.0;
  test.explained = Eigen::VectorXd::Zero(axes);
  for (Eigen::Index i = 0; i < axes; ++i) {
    const double noise = plain.left.middleRows(i * n, n).squaredNorm() / freedom * static_cast<double>(axes);
    const double unexplained = std::max(0.0, along.middleRows(i * n, n).squaredNorm() - noise);
    const Eigen::MatrixXd force = response.middleRows(i * n, n);
    const double variation = (force.rowwise() - force.colwise().mean()).squaredNorm();
    if (variation > 0.0) test.explained[i] = 1.0 - unexplained / variation;
    misfit += along.middleRows(i * n, n).squaredNorm() - noise;
  }
  test.share = std::sqrt(std::max(0.0, misfit) / response.squaredNorm());
  return test;
}

}  // namespace tonus::refined
