#include "analysis_service/refined/residual_process.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tonus::refined {
namespace {

constexpr double kLargestPole = 0.995;

/// Sums of squares of [e(t-1) ... e(t-order), e(t)] over t from `first` on, and how many rows they have.
struct Moments {
  Eigen::MatrixXd gram;
  Eigen::Index rows = 0;
};

Moments moments_of(const std::vector<Eigen::MatrixXd>& residuals, Eigen::Index order, Eigen::Index first) {
  const Eigen::Index axes = residuals.front().cols();
  const Eigen::Index width = axes * (order + 1);
  Moments moments{Eigen::MatrixXd::Zero(width, width), 0};
  for (const Eigen::MatrixXd& e : residuals) {
    const Eigen::Index rows = e.rows() - first;
    if (rows <= 0) continue;
    Eigen::MatrixXd lagged(rows, width);
    for (Eigen::Index lag = 1; lag <= order; ++lag)
      lagged.middleCols(axes * (lag - 1), axes) = e.middleRows(first - lag, rows);
    lagged.rightCols(axes) = e.bottomRows(rows);
    moments.gram.noalias() += lagged.transpose() * lagged;
    moments.rows += rows;
  }
  return moments;
}

/// Companion matrix of A, whose state is [e(t); e(t-1); ...].
Eigen::MatrixXd companion(const std::vector<Eigen::MatrixXd>& A) {
  const Eigen::Index axes = A.front().rows();
  const auto size = axes * static_cast<Eigen::Index>(A.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < A.size(); ++i)
    C.block(0, axes * static_cast<Eigen::Index>(i), axes, axes) = A[i];
  C.bottomLeftCorner(size - axes, size - axes).setIdentity();
  return C;
}

/// P = C P C' + Q by doubling; C has no pole on or beyond the unit circle.
Eigen::MatrixXd stationary_covariance(Eigen::MatrixXd C, Eigen::MatrixXd P) {
  for (int doubling = 0; doubling < 16; ++doubling) {
    P += (C * P * C.transpose()).eval();
    C = (C * C).eval();
  }
  return 0.5 * (P + P.transpose());
}

void bring_inside(std::vector<Eigen::MatrixXd>& A) {
  const double largest = companion(A).eigenvalues().cwiseAbs().maxCoeff();
  if (!(largest > kLargestPole)) return;
  const double factor = kLargestPole / largest;
  double power = 1.0;
  for (Eigen::MatrixXd& coefficient : A) coefficient *= (power *= factor);
}

}  // namespace

Eigen::Index chosen_order(const std::vector<Eigen::MatrixXd>& residuals) {
  const Eigen::Index axes = residuals.front().cols();
  const Eigen::Index most = std::min(kHighestOrder, residuals.front().rows() / 4);
  const Moments moments = moments_of(residuals, most, most);
  const Eigen::MatrixXd squares = moments.gram.bottomRightCorner(axes, axes);
  Eigen::Index best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index order = 0; order <= most; ++order) {
    const Eigen::Index width = axes * order;
    Eigen::MatrixXd left = squares;
    if (order > 0) {
      const Eigen::MatrixXd cross = moments.gram.topRightCorner(width, axes);
      left -= cross.transpose() * moments.gram.topLeftCorner(width, width).ldlt().solve(cross);
    }
    const auto rows = static_cast<double>(moments.rows);
    const double determinant = (left / rows).determinant();
    const double criterion = rows * std::log(determinant) + 2.0 * static_cast<double>(axes * width);
    if (criterion < least) {
      least = criterion;
      best = order;
    }
  }
  return best;
}

ResidualProcess fit_process(const std::vector<Eigen::MatrixXd>& residuals, Eigen::Index order) {
  const Eigen::Index axes = residuals.front().cols();
  const Moments moments = moments_of(residuals, order, order);
  const Eigen::Index width = axes * order;
  ResidualProcess process;
  Eigen::MatrixXd left = moments.gram.bottomRightCorner(axes, axes);
  if (order > 0) {
    const Eigen::MatrixXd cross = moments.gram.topRightCorner(width, axes);
    const Eigen::MatrixXd solution = moments.gram.topLeftCorner(width, width).ldlt().solve(cross);
    left -= cross.transpose() * solution;
    for (Eigen::Index i = 0; i < order; ++i)
      process.A.emplace_back(solution.middleRows(axes * i, axes).transpose());
    bring_inside(process.A);
  }
  process.S = left / static_cast<double>(std::max<Eigen::Index>(1, moments.rows - width));
  if (order == 0) return process;
  Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(width, width);
  Q.topLeftCorner(axes, axes) = process.S;
  process.state = stationary_covariance(companion(process.A), Q);
  return process;
}

Eigen::MatrixXd covariance_of_mean(const ResidualProcess& process, Eigen::Index n) {
  const auto count = static_cast<double>(n);
  if (process.A.empty()) return process.S / count;
  const Eigen::Index axes = process.S.rows();
  const Eigen::MatrixXd C = companion(process.A);
  Eigen::MatrixXd lagged = process.state;  // first rows: cov(e(t + k), e(t))
  Eigen::MatrixXd sum = count * lagged.topLeftCorner(axes, axes);
  for (Eigen::Index k = 1; k < n; ++k) {
    lagged = (C * lagged).eval();
    const Eigen::MatrixXd G = lagged.topLeftCorner(axes, axes);
    sum += static_cast<double>(n - k) * (G + G.transpose());
  }
  return sum / (count * count);
}

}  // namespace tonus::refined
