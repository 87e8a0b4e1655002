#include "analysis_service/refined/whitener.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

namespace tonus::refined {
namespace {

constexpr Eigen::Index kRows = 30;

ResidualProcess two_axes() {
  ResidualProcess process;
  process.A = {(Eigen::Matrix2d() << 0.6, 0.0, 0.0, -0.3).finished()};
  process.S = (Eigen::Matrix2d() << 2.0, 0.0, 0.0, 0.5).finished();
  process.state = (Eigen::Matrix2d() << 2.0 / (1.0 - 0.36), 0.0, 0.0, 0.5 / (1.0 - 0.09)).finished();
  return process;
}

/// Rows of the first axis, then of the second: a^|i-j| s / (1 - a2), plus what all rows share.
Eigen::MatrixXd covariance(const Eigen::Matrix2d& shared) {
  Eigen::MatrixXd T(2 * kRows, 2 * kRows);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    for (Eigen::Index j = 0; j < kRows; ++j) {
      const auto apart = static_cast<double>(std::abs(i - j));
      T(i, j) = 2.0 / (1.0 - 0.36) * std::pow(0.6, apart) + shared(0, 0);
      T(kRows + i, kRows + j) = 0.5 / (1.0 - 0.09) * std::pow(-0.3, apart) + shared(1, 1);
      T(i, kRows + j) = shared(0, 1);
      T(kRows + i, j) = shared(1, 0);
    }
  }
  return T;
}

/// The whitener's matrix, column by column.
Eigen::MatrixXd matrix_of(const Whitener& whitener) {
  Eigen::MatrixXd W(2 * kRows, 2 * kRows);
  for (Eigen::Index i = 0; i < 2 * kRows; ++i) {
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(kRows, 2);
    unit(i % kRows, i / kRows) = 1.0;
    W.col(i) = whitener.signal(unit);
  }
  return W;
}

double distance_from_identity(const Eigen::MatrixXd& m) {
  return (m - Eigen::MatrixXd::Identity(m.rows(), m.cols())).cwiseAbs().maxCoeff();
}

TEST(Whitener, TurnsTheCovarianceOfItsProcessIntoTheIdentity) {
  const Eigen::MatrixXd W = matrix_of(Whitener(two_axes(), kRows, Eigen::Matrix2d::Zero()));
  EXPECT_LT(distance_from_identity(W * covariance(Eigen::Matrix2d::Zero()) * W.transpose()), 1e-9);
}

TEST(Whitener, TakesTheScatterOfOffsetsIntoAccount) {
  const Eigen::Matrix2d scatter = (Eigen::Matrix2d() << 0.4, 0.1, 0.1, 0.2).finished();
  const Eigen::MatrixXd W = matrix_of(Whitener(two_axes(), kRows, scatter));
  EXPECT_LT(distance_from_identity(W * covariance(scatter) * W.transpose()), 1e-9);
}

TEST(Whitener, TreatsRegressorsAsItDoesTheForceThatTheyMake) {
  const Whitener whitener(two_axes(), kRows, Eigen::Matrix2d::Identity());
  const Eigen::MatrixXd phi = Eigen::MatrixXd::Random(kRows, 3);
  const Eigen::MatrixXd theta = Eigen::MatrixXd::Random(3, 2);
  const Eigen::VectorXd direct = whitener.signal(phi * theta);
  EXPECT_LT((whitener.design(phi) * theta.reshaped() - direct).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace tonus::refined
