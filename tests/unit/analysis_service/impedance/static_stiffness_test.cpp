#include "analysis_service/impedance/static_stiffness.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

/// Moves along x at 50 mm/s but for rows [still, still + rows), at 200 Hz; the force is 2 N where it stands.
Trial with_stretch(Eigen::Index still, Eigen::Index rows, Eigen::Index total) {
  Trial trial;
  trial.number = 1;
  trial.sample_period = 0.005;
  trial.onset = 10;
  trial.displacement = Signals::Zero(total, 2);
  trial.force = Signals::Zero(total, 2);
  double x = 0.0;
  for (Eigen::Index k = 0; k < total; ++k) {
    if (k < still || k >= still + rows) x += 0.05 * 0.005;
    trial.displacement(k, 0) = x;
    trial.force(k, 1) = k >= still && k < still + rows ? 2.0 : 0.0;
  }
  return trial;
}

TEST(StaticPoint, IsTheLastStretchThatStandsStillLongEnough) {
  const auto point = static_point(with_stretch(100, 100, 300), {});
  ASSERT_TRUE(point);
  // The filter rounds the corners: the stretch found lies within the true one, 0.05 s at most shorter at each
  // end.
  EXPECT_GE(point->first, 100);
  EXPECT_LE(point->first, 110);
  EXPECT_LE(point->first + point->rows, 200);
  EXPECT_GE(point->first + point->rows, 190);
  EXPECT_NEAR(point->X[0], 0.025, 1e-12);
  EXPECT_NEAR(point->F[1], 2.0, 1e-12);
}

TEST(StaticPoint, IsNoneWhereNothingStandsStillForTwoHundredMilliseconds) {
  EXPECT_FALSE(static_point(with_stretch(100, 36, 300), {}));
  EXPECT_FALSE(static_point(with_stretch(0, 0, 300), {}));
}

TEST(StaticPoint, DoesNotReachIntoTheRestBeforeTheOnset) {
  Trial trial = with_stretch(0, 100, 300);
  trial.onset = 80;
  EXPECT_FALSE(static_point(trial, {}));
}

TEST(StaticStiffness, IsExactOnExactPoints) {
  Eigen::Matrix2d K;
  K << 180.0, -100.0, -95.0, 340.0;
  const Eigen::Vector2d X0(-0.004, 0.003);
  std::vector<Trial> trials;
  for (std::uint32_t i = 0; i < 8; ++i) {
    const double angle = i * std::numbers::pi / 4.0;
    const Eigen::Vector2d X(0.005 * std::cos(angle), 0.005 * std::sin(angle));
    Trial trial;
    trial.number = i;
    trial.sample_period = 0.005;
    trial.onset = 10;
    trial.displacement = Signals::Zero(100, 2);
    trial.displacement.bottomRows(90) = X.transpose().replicate(90, 1);
    trial.force = (K * (X - X0)).transpose().replicate(100, 1);
    trials.push_back(trial);
  }
  const StaticStiffness found = static_stiffness(trials, {}).value();
  EXPECT_LT((Eigen::Matrix2d(found.K) - K).norm(), 1e-9 * K.norm());
  EXPECT_LT((Eigen::Vector2d(found.X0) - X0).norm(), 1e-12);
  EXPECT_LT(found.K_std.maxCoeff(), 1e-6);
  EXPECT_EQ(found.points.size(), 8U);
  EXPECT_TRUE(found.moving.empty());
}

TEST(StaticStiffness, FindsStiffnessAndSpringCentreOfASimulatedLoadedArm) {
  SimulatedArm arm = typical_subject();
  const Eigen::Vector2d F_bias(0.6, -0.6);
  arm.X0 = predicted_spring_centre(arm.impedance.K, F_bias).value();
  SimulatedRig rig;
  rig.damping = 40.0;
  rig.duration = 2.0;
  const auto trials = simulate(arm, rig, directions(), 5, false);
  EXPECT_NEAR(trials[0].force(0, 0), F_bias.x(), 0.25);  // At rest the rig holds the arm with the bias force.
  const StaticStiffness found = static_stiffness(trials, {}).value();
  EXPECT_LT(relative_error(found.K, arm.impedance.K), 0.06);
  const SpringCentreComparison comparison = compare(Eigen::Vector2d(found.X0), arm.X0);
  EXPECT_NEAR(comparison.magnitude_ratio, 1.0, 0.1);
  EXPECT_NEAR(comparison.turn, 0.0, 0.1);
  for (Eigen::Index i = 0; i < 4; ++i) {
    EXPECT_LT(std::abs(found.K.reshaped()[i] - arm.impedance.K.reshaped()[i]),
              4.0 * found.K_std.reshaped()[i]);
  }
}

TEST(StaticStiffness, RefusesTrialsThatDoNotDetermineIt) {
  EXPECT_FALSE(static_stiffness({}, {}));
  const Trial moving = with_stretch(0, 0, 300);
  EXPECT_EQ(static_stiffness({&moving, 1}, {}).error().message,
            "static stiffness: 0 of 1 trials stand still, which does not determine it");
  const std::vector<Trial> same(5, with_stretch(100, 100, 300));
  EXPECT_FALSE(static_stiffness(same, {}));
  EXPECT_FALSE(static_stiffness(same, {.duration = 0.0}));
}

TEST(SpringCentre, PullsAgainstTheBiasForce) {
  // A handle that pushes the arm to +x at X = 0 is held by a spring whose centre lies at -x.
  const auto centre = predicted_spring_centre(200.0 * Eigen::Matrix2d::Identity(), {1.0, 0.0}).value();
  EXPECT_NEAR(centre.x(), -0.005, 1e-15);
  EXPECT_FALSE(predicted_spring_centre(Eigen::Matrix2d::Zero(), {1.0, 0.0}));
}

TEST(SpringCentre, IsComparedByLengthAndAngle) {
  const auto c = compare({0.0, 0.002}, {0.001, 0.0});
  EXPECT_NEAR(c.magnitude_ratio, 2.0, 1e-12);
  EXPECT_NEAR(c.turn, std::numbers::pi / 2.0, 1e-12);
}

}  // namespace
}  // namespace tonus::impedance::test
