#include "analysis_service/certify/imperfect_arm.hpp"

#include <Eigen/Dense>
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

TEST(ImperfectArm, HandleMovesFreelyWithinTheSlack) {
  const auto [truth, motion] = settle({.slack = 0.01}, 0.005);
  EXPECT_EQ(motion.force.cwiseAbs().maxCoeff(), 0.0);
  EXPECT_GT(last(motion.x).norm(), 0.004);
}

}  // namespace
}  // namespace tonus::certify
