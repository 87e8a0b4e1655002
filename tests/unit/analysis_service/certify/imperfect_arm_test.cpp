#include "analysis_service/certify/imperfect_arm.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

namespace tonus::certify {
namespace {

Eigen::Vector2d last(const Eigen::MatrixXd& signal) { return signal.bottomRows(1).transpose(); }

/// Quiet arm, long enough to come to rest.
struct Settled {
  Truth truth;
  Motion motion;
};
Settled settle(const ModelError& error, double amplitude) {
  std::mt19937_64 random(3);
  Settled settled{draw_truth(1, random), {}};
  Design design;
  design.window = 6.0;
  design.amplitude = amplitude;
  settled.motion = simulate_imperfect(settled.truth, design, {}, error, target_of(design, 1), random);
  return settled;
}

TEST(ImperfectArm, MovesAsTheLinearOneWhereNothingIsWrong) {
  std::mt19937_64 random(3);
  const Truth truth = draw_truth(1, random);
  const Motion exact = simulate_motion(truth, {}, {}, target_of({}, 3), random);
  const Motion found = simulate_imperfect(truth, {}, {}, {}, target_of({}, 3), random);
  EXPECT_LT((exact.x - found.x).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LT((exact.force - found.force).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(ImperfectArm, ReflexAddsToTheForceAtRestInItsShareOfTheStiffness) {
  const auto [truth, motion] = settle({.reflex = 0.4}, 0.005);
  const Eigen::Vector2d expected = 1.4 * truth.arm.K * last(motion.x);
  EXPECT_LT((last(motion.force) - expected).norm(), 1e-3 * expected.norm());
}

TEST(ImperfectArm, HardeningIsWhatItsShareSaysAtFiveMillimetres) {
  const auto [truth, motion] = settle({.hardening = 0.3}, 0.005);
  const Eigen::Vector2d x = last(motion.x);
  const Eigen::Vector2d expected = (1.0 + 0.3 * x.squaredNorm() / 25e-6) * truth.arm.K * x;
  EXPECT_LT((last(motion.force) - expected).norm(), 1e-3 * expected.norm());
}

TEST(ImperfectArm, FrictionOpposesTheMotionAndIsGoneAtRest) {
  // The rig drives both arms alike but for the friction: in the ramp's middle it asks for so much more force.
  std::mt19937_64 random(3);
  const Truth truth = draw_truth(1, random);
  Design design;
  design.rise = 0.8;
  const auto row = static_cast<Eigen::Index>(std::llround(0.9 / design.sample_period));
  const Eigen::Vector2d target = target_of(design, 0);
  const Motion rubbing = simulate_imperfect(truth, design, {}, {.friction = 0.3}, target, random);
  const Eigen::Vector2d v = rubbing.velocity.row(row).transpose();
  const Eigen::Vector2d x = rubbing.x.row(row).transpose();
  const Eigen::Vector2d a = (rubbing.velocity.row(row + 1) - rubbing.velocity.row(row - 1)).transpose() /
                            (2.0 * design.sample_period);
  const Eigen::Vector2d beyond =
      rubbing.force.row(row).transpose() - truth.arm.M * a - truth.arm.B * v - truth.arm.K * x;
  EXPECT_NEAR(beyond.norm(), 0.3 * v.norm() / (v.norm() + 5e-4), 0.005);  // half of it at 0.5 mm/s
  EXPECT_GT(beyond.dot(v), 0.0);
}

TEST(ImperfectArm, SlowImpedanceIsTheForceOfASlowMotionWithReflex) {
  std::mt19937_64 random(3);
  const Truth truth = draw_truth(1, random);
  const ModelError error{.reflex = 0.4};
  const auto slow = slow_impedance(truth, error);
  // x = e^(st) with s = 1/s: the force of the delayed spring by its closed form.
  const Eigen::Matrix2d exact =
      truth.arm.M + truth.arm.B + truth.arm.K * (1.0 + 0.4 * std::exp(-error.reflex_delay));
  EXPECT_LT((slow.M + slow.B + slow.K - exact).norm(), 1e-4 * truth.arm.K.norm());
}

TEST(ImperfectArm, HandleMovesFreelyWithinTheSlack) {
  const auto [truth, motion] = settle({.slack = 0.01}, 0.005);
  EXPECT_EQ(motion.force.cwiseAbs().maxCoeff(), 0.0);
  EXPECT_GT(last(motion.x).norm(), 0.004);
}

}  // namespace
}  // namespace tonus::certify
