#include "analysis_service/certify/drawn_session.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

namespace tonus::certify {
namespace {

TEST(DrawnSession, EndsWhereTheSpringsOfRigAndArmAreInBalance) {
  std::mt19937_64 random(3);
  const Truth truth = draw_truth(2, random);
  Design design;
  design.window = 10.0;
  const Eigen::Vector2d target = target_of(design, 1);
  const Motion motion = simulate_motion(truth, design, {}, target, random);
  const Eigen::Vector2d expected =
      (truth.arm.K + truth.rig_stiffness).inverse() * truth.rig_stiffness * target;
  EXPECT_LT((motion.x.bottomRows(1).transpose() - expected).norm(), 1e-6);
  EXPECT_LT((motion.force.bottomRows(1).transpose() - truth.arm.K * expected).norm(), 1e-3);
}

TEST(DrawnSession, OwnForceOfTheArmHasTheStatedSize) {
  std::mt19937_64 random(4);
  Truth truth = draw_truth(0, random);
  truth.rig_stiffness = 1e9 * Eigen::Matrix2d::Identity();  // nothing moves: the force is the arm's own
  truth.rig_damping = 1e6 * Eigen::Matrix2d::Identity();
  Design design;
  design.amplitude = 0.0;
  design.window = 400.0;
  const Motion motion =
      simulate_motion(truth, design, settings().back().disturbance, Eigen::Vector2d::Zero(), random);
  const double power = motion.force.squaredNorm() / static_cast<double>(motion.force.size());
  EXPECT_NEAR(std::sqrt(power), std::sqrt(0.2 * 0.2 + 0.1 * 0.1), 0.02);
}

TEST(DrawnSession, RoundsDisplacementToEncoderStepsOfTheRigsJoints) {
  std::mt19937_64 random(5);
  const Truth truth = draw_truth(0, random);
  const auto trials = simulate_condition(truth, {}, settings()[1], random);
  ASSERT_EQ(trials.size(), 16U);
  const auto& x = trials[0].displacement;
  const Eigen::Vector2d step = settings()[1].sensors.encoder_step * Eigen::Vector2d::Ones();
  for (Eigen::Index k = 1; k < x.rows(); ++k) {
    const Eigen::Vector2d counts =
        (truth.rig_jacobian.inverse() * (x.row(k) - x.row(0)).transpose()).cwiseQuotient(step);
    EXPECT_LT((counts.array() - counts.array().round()).abs().maxCoeff(), 1e-6);
  }
}

TEST(DrawnSession, SameSeedGivesTheSameCondition) {
  std::mt19937_64 first(9);
  std::mt19937_64 second(9);
  const auto a = simulate_condition(draw_truth(1, first), {}, settings()[2], first);
  const auto b = simulate_condition(draw_truth(1, second), {}, settings()[2], second);
  EXPECT_EQ(a[3].force, b[3].force);
}

}  // namespace
}  // namespace tonus::certify
