#include "analysis_service/certify/bound.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace tonus::certify {
namespace {

TEST(CramerRao, OfTwoSinesInWhiteNoiseIsItsClosedForm) {
  // x = a1 cos w1 t + a2 cos w2 t over whole periods: sums of squares N/2, x' apart from x and x". So the
  // variance of B is s2 / (N/2 (a1^2 w1^2 + a2^2 w2^2)), and of M and K that of a 2x2 system.
  constexpr Eigen::Index kRows = 400;
  const double a1 = 0.5;
  const double a2 = 0.3;
  const double w1 = 2.0 * std::numbers::pi * 3.0;
  const double w2 = 2.0 * std::numbers::pi * 7.0;
  Eigen::MatrixXd phi(kRows, 3);
  for (Eigen::Index k = 0; k < kRows; ++k) {
    const double t = static_cast<double>(k) / kRows;
    const double c1 = a1 * std::cos(w1 * t);
    const double c2 = a2 * std::cos(w2 * t);
    phi.row(k) << -w1 * w1 * c1 - w2 * w2 * c2, -a1 * w1 * std::sin(w1 * t) - a2 * w2 * std::sin(w2 * t),
        c1 + c2;
  }
  const double variance = 0.04;
  const Eigen::MatrixXd bound = cramer_rao({phi}, variance * Eigen::MatrixXd::Identity(kRows, kRows), 1);
  const double half = 0.5 * kRows;
  const double mm = half * (a1 * a1 * std::pow(w1, 4) + a2 * a2 * std::pow(w2, 4));
  const double mk = -half * (a1 * a1 * w1 * w1 + a2 * a2 * w2 * w2);
  const double kk = half * (a1 * a1 + a2 * a2);
  const double determinant = mm * kk - mk * mk;
  EXPECT_NEAR(bound(0, 0) * determinant / (variance * kk), 1.0, 1e-9);
  EXPECT_NEAR(bound(1, 1) * -mk / variance, 1.0, 1e-9);
  EXPECT_NEAR(bound(2, 2) * determinant / (variance * mm), 1.0, 1e-9);
}

TEST(CramerRao, OfAnOffsetInFirstOrderNoiseIsItsClosedForm) {
  // 1' Gamma^-1 1 = (n (1 - a)^2 + 2 a (1 - a)) / s2 for e(t) = a e(t-1) + w, w of variance s2.
  constexpr Eigen::Index kRows = 50;
  const double a = 0.8;
  Eigen::MatrixXd gamma(kRows, kRows);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    for (Eigen::Index j = 0; j < kRows; ++j)
      gamma(i, j) = std::pow(a, static_cast<double>(std::abs(i - j))) / (1.0 - a * a);
  }
  const Eigen::MatrixXd ones = Eigen::MatrixXd::Ones(kRows, 1);
  const double information = kRows * (1.0 - a) * (1.0 - a) + 2.0 * a * (1.0 - a);
  EXPECT_NEAR(cramer_rao({ones}, gamma, 1)(0, 0), 1.0 / information, 1e-12);
  EXPECT_NEAR(cramer_rao({ones, ones}, gamma, 1)(0, 0), 0.5 / information, 1e-12);
}

TEST(CramerRao, FallsWithTheRootOfTheTrialsAndInProportionToTheForceNoise) {
  std::mt19937_64 random(1);
  const Truth truth = draw_truth(0, random);
  Design design;
  design.trials = 8;
  Setting setting = settings().front();
  setting.sensors.displacement_noise = 0.0;
  const Eigen::VectorXd once = bound_of(truth, design, setting);
  design.trials = 32;
  setting.sensors.force_noise *= 3.0;
  const Eigen::VectorXd ratio = bound_of(truth, design, setting).cwiseQuotient(once);
  EXPECT_LT((ratio.array() - 1.5).abs().maxCoeff(), 1e-6);
}

}  // namespace
}  // namespace tonus::certify
