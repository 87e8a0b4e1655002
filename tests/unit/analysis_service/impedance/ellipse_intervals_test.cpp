#include "analysis_service/impedance/ellipse_intervals.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "analysis_service/impedance/ellipse.hpp"
#include "analysis_service/impedance/identification.hpp"
#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

constexpr double kMany = 1e6;  // degrees of freedom: the normal distribution, quantile 1.95996

EllipseIntervals intervals(const Eigen::Matrix2d& Z, const Eigen::Matrix4d& C, double freedom = kMany) {
  return ellipse_intervals(Z, C, [&](const Eigen::Vector4d& w) {
    return CombinationSpread{std::sqrt(w.dot(C * w)), freedom};
  });
}

TEST(EllipseIntervals, OfADiagonalMatrixAreThoseOfItsElements) {
  Eigen::Matrix2d Z;
  Z << 100.0, 0.0, 0.0, 400.0;
  const double s = 2.0;
  const EllipseIntervals found = intervals(Z, s * s * Eigen::Matrix4d::Identity());
  // Closed forms: log size = log l1 + log l2, log shape = log l2 - log l1, angle = e / (l2 - l1), curl = za /
  // 200.
  const double relative = 1.95996 * std::hypot(s / 100.0, s / 400.0);
  EXPECT_NEAR(std::log(found.size.high / found.size.low), 2.0 * relative, 1e-5);
  EXPECT_NEAR(std::log(found.shape.high / found.shape.low), 2.0 * relative, 1e-3);
  const double angle = 1.95996 * (s / std::numbers::sqrt2) / 300.0;
  EXPECT_NEAR(found.orientation.high - found.orientation.low, 2.0 * angle, 1e-7);
  EXPECT_NEAR(0.5 * (found.orientation.high + found.orientation.low), 0.5 * std::numbers::pi, 1e-9);
  EXPECT_EQ(found.curl.low, 0.0);
  EXPECT_NEAR(found.curl.high, 1.95996 * (s / std::numbers::sqrt2) / 200.0, 1e-7);
}

TEST(EllipseIntervals, LeaveTheOrientationOfWhatMayBeACircleOpen) {
  Eigen::Matrix2d Z;
  Z << 300.0, 1.0, 1.0, 302.0;
  const EllipseIntervals found = intervals(Z, 25.0 * Eigen::Matrix4d::Identity());
  EXPECT_FALSE(std::isfinite(found.orientation.low));
  EXPECT_FALSE(std::isfinite(found.orientation.high));
  EXPECT_EQ(found.shape.low, 1.0);
  EXPECT_GT(found.shape.high, 302.0 / 300.0);
  EXPECT_TRUE(std::isfinite(found.size.low));
}

TEST(EllipseIntervals, AreNotFiniteWhereThereIsNoEllipse) {
  Eigen::Matrix2d Z;
  Z << 300.0, 0.0, 0.0, -1.0;
  EXPECT_FALSE(std::isfinite(intervals(Z, Eigen::Matrix4d::Identity()).size.low));
}

/// Shares of drawn matrices whose intervals hold the truth, normal errors of standard deviation s.
struct Shares {
  double size = 0.0;
  double shape = 0.0;
  double orientation = 0.0;  // of those that have one
  double curl = 0.0;
  double oriented = 0.0;
};

Shares shares(const Eigen::Matrix2d& truth, double s) {
  constexpr int kDraws = 4000;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, s);
  const Ellipse ellipse = *ellipse_of(truth);
  const double curl = curl_of(truth)->p_mean;
  const auto holds = [](const Interval& interval, double value) {
    return interval.low <= value + 1e-9 && value - 1e-9 <= interval.high ? 1.0 : 0.0;
  };
  Shares found;
  for (int i = 0; i < kDraws; ++i) {
    Eigen::Matrix2d Z = truth;
    for (double& value : Z.reshaped()) value += normal(random);
    const EllipseIntervals one = intervals(Z, s * s * Eigen::Matrix4d::Identity());
    found.size += holds(one.size, ellipse.size) / kDraws;
    found.shape += holds(one.shape, ellipse.shape) / kDraws;
    found.curl += holds(one.curl, curl) / kDraws;
    if (!std::isfinite(one.orientation.low)) continue;
    const double middle = 0.5 * (one.orientation.low + one.orientation.high);
    found.oriented += 1.0;
    found.orientation += holds(one.orientation, middle + rotation_between(middle, ellipse.orientation));
  }
  found.orientation /= std::max(1.0, found.oriented);
  found.oriented /= kDraws;
  return found;
}

TEST(EllipseIntervals, HoldTheTruthNineteenTimesInTwenty) {
  Eigen::Matrix2d truth;
  truth << 400.0, 60.0, 90.0, 200.0;
  for (const double s : {2.0, 15.0}) {
    const Shares found = shares(truth, s);
    // One standard error of a share of 95 % of 4000 is 0.35 %. With s = 15 the antisymmetric part, 15, is 1.4
    // of its standard deviations from 0: its sign is not known, and the interval can miss the truth on its
    // upper side alone.
    const double curl = s > 10.0 ? 0.975 : 0.95;
    EXPECT_NEAR(found.size, 0.95, 0.015) << s;
    EXPECT_NEAR(found.shape, 0.95, 0.015) << s;
    EXPECT_NEAR(found.orientation, 0.95, 0.015) << s;
    EXPECT_NEAR(found.curl, curl, 0.015) << s;
    EXPECT_GT(found.oriented, 0.99) << s;
  }
}

TEST(EllipseIntervals, OfACircleHoldItsShapeAndSeldomClaimAnOrientation) {
  const Shares found = shares(300.0 * Eigen::Matrix2d::Identity(), 10.0);
  EXPECT_NEAR(found.shape, 0.95, 0.02);
  EXPECT_NEAR(found.oriented, 0.05, 0.015);
  EXPECT_NEAR(found.curl, 0.95, 0.015);
}

TEST(EllipseIntervals, HullHoldsBothAndKnowsThatAHalfTurnIsTheSameAxis) {
  const double pi = std::numbers::pi;
  const EllipseIntervals a{{1.0, 2.0}, {1.0, 3.0}, {0.45 * pi, 0.55 * pi}, {0.0, 0.1}};
  const EllipseIntervals b{{0.5, 1.5}, {1.5, 4.0}, {-0.52 * pi, -0.42 * pi}, {0.05, 0.2}};
  const EllipseIntervals both = hull(a, b);
  EXPECT_EQ(both.size.low, 0.5);
  EXPECT_EQ(both.size.high, 2.0);
  EXPECT_EQ(both.shape.high, 4.0);
  EXPECT_NEAR(both.orientation.low, 0.45 * pi, 1e-12);
  EXPECT_NEAR(both.orientation.high, 0.58 * pi, 1e-12);
  EXPECT_EQ(both.curl.low, 0.0);
  EXPECT_EQ(both.curl.high, 0.2);
}

TEST(MatrixUncertainty, HasTheVariancesOfTheElementsRowByRowByEveryMethod) {
  const auto trials = simulate(typical_subject(), rig_with_command(), directions(), 3);
  for (const Method method : kPerturbationMethods) {
    Options options;
    options.method = method;
    const Estimate found = identify(trials, options).value();
    const auto hold = [&](const MatrixUncertainty& uncertainty, const AxisMatrix& std) {
      ASSERT_EQ(uncertainty.covariance.rows(), 4);
      for (Eigen::Index i = 0; i < 2; ++i) {
        for (Eigen::Index j = 0; j < 2; ++j)
          EXPECT_NEAR(std::sqrt(uncertainty.covariance(2 * i + j, 2 * i + j)), std(i, j), 1e-9 * std(i, j))
              << name_of(method);
      }
      ASSERT_TRUE(uncertainty.ellipse);
      EXPECT_GT(uncertainty.freedom, 0.0);
    };
    hold(found.uncertainty.M, found.std.M);
    hold(found.uncertainty.B, found.std.B);
    hold(found.uncertainty.K, found.std.K);
    ASSERT_EQ(found.X0_covariance.rows(), 2);
    EXPECT_NEAR(std::sqrt(found.X0_covariance(1, 1)), found.std.X0[1], 1e-9 * found.std.X0[1]);
  }
}

}  // namespace
}  // namespace tonus::impedance::test
