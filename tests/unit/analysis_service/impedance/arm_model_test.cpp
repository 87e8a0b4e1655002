#include "analysis_service/impedance/arm_model.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

TEST(ArmModel, HasTheInertiaOfItsSlicedCylinders) {
  // Kinetic energy summed over thin disks (mass dm, transverse inertia dm r^2/4) at rates (a, b) is 1/2 q' I
  // q.
  const ArmModel arm = typical_arm();
  const Eigen::Vector2d t(0.9, 1.4);
  const int slices = 20000;
  const auto energy = [&](double a, double b) {
    double sum = 0.0;
    for (int i = 0; i < slices; ++i) {
      const double share = (i + 0.5) / slices;
      const double u = share * arm.upper_arm.length;
      sum +=
          arm.upper_arm.mass / slices * (u * u + arm.upper_arm.radius * arm.upper_arm.radius / 4.0) * a * a;
      const double w = share * arm.forearm.length;
      const Eigen::Vector2d v(
          -arm.upper_arm.length * std::sin(t[0]) * a - w * std::sin(t[0] + t[1]) * (a + b),
          arm.upper_arm.length * std::cos(t[0]) * a + w * std::cos(t[0] + t[1]) * (a + b));
      sum += arm.forearm.mass / slices *
             (v.squaredNorm() + arm.forearm.radius * arm.forearm.radius / 4.0 * (a + b) * (a + b));
    }
    return sum;
  };
  const Eigen::Matrix2d I = arm.inertia(t);
  EXPECT_NEAR(I(0, 0), energy(1.0, 0.0), 1e-8);
  EXPECT_NEAR(I(1, 1), energy(0.0, 1.0), 1e-8);
  EXPECT_NEAR(2.0 * I(0, 1), energy(1.0, 1.0) - energy(1.0, 0.0) - energy(0.0, 1.0), 1e-8);
  EXPECT_EQ(I(0, 1), I(1, 0));
}

TEST(ArmModel, HasTheCoriolisTorqueThatKeepsEnergy) {
  // d/dt(1/2 q' I q) = q' tau, with q" = 0: q' C = 1/2 q' (dI/dt) q', and the elbow's part is -1/2 q' dI/dt2
  // q.
  const ArmModel arm = typical_arm();
  const Eigen::Vector2d t(0.7, 1.1);
  const Eigen::Vector2d rates(1.3, -0.8);
  const double step = 1e-6;
  const Eigen::Matrix2d slope =
      (arm.inertia(t + Eigen::Vector2d(0.0, step)) - arm.inertia(t - Eigen::Vector2d(0.0, step))) /
      (2.0 * step);
  const Eigen::Vector2d C = arm.coriolis_torque(t, rates);
  // Lagrange: C = dI/dt q' - 1/2 d(q' I q)/dt, I depends on t2 only.
  const Eigen::Vector2d expected =
      slope * rates * rates[1] - 0.5 * Eigen::Vector2d(0.0, rates.dot(slope * rates));
  EXPECT_NEAR((C - expected).norm(), 0.0, 1e-8);
}

TEST(ArmModel, MapsTheCoriolisTorqueToTheEndpoint) {
  const ArmModel arm = typical_arm();
  const Eigen::Vector2d t(0.7, 1.1);
  const Eigen::Matrix2d J = arm.links().jacobian(t);
  const Eigen::Vector2d v(0.3, -0.5);
  const Eigen::Vector3d products(v.x() * v.x(), v.x() * v.y(), v.y() * v.y());
  const Eigen::Vector2d rates = J.inverse() * v;
  const Eigen::Vector2d neglecting = J.transpose().inverse() * arm.coriolis_torque(t, rates);
  EXPECT_LT((arm.coriolis_matrix(t) * products - neglecting).norm(), 1e-12);

  // With the Jacobian's rate: no endpoint acceleration means J q" + J' q' = 0.
  const Eigen::Vector2d q2 = -J.inverse() * arm.links().jacobian_rate(t, rates) * rates;
  const Eigen::Vector2d exact =
      J.transpose().inverse() * (arm.inertia(t) * q2 + arm.coriolis_torque(t, rates));
  EXPECT_LT((arm.coriolis_matrix(t, true) * products - exact).norm(), 1e-12);
}

TEST(ArmModel, TakesJointMatricesToTheEndpointAndBack) {
  const JointImpedance stiffness{20.0, 15.0, 6.0};
  Eigen::Matrix2d expected;
  expected << 26.0, 6.0, 6.0, 21.0;
  EXPECT_EQ(stiffness.matrix(), expected);
  const Eigen::Matrix2d J = typical_arm().links().jacobian({0.9, 1.4});
  const Eigen::Matrix2d endpoint = to_endpoint(stiffness.matrix(), J);
  EXPECT_LT((to_joints(endpoint, J) - expected).norm(), 1e-12);
  // Virtual work: the same torque for the same small turn.
  const Eigen::Vector2d turn(1e-3, -2e-3);
  EXPECT_LT((J.transpose() * endpoint * J * turn - expected * turn).norm(), 1e-12);
}

TEST(ArmModel, HasMassesOfTheSizeThatThePaperDraws) {
  // Fig. 5 and 7: calibration circles of 2.0 to 2.5 kg; the radial mass exceeds the tangential one.
  for (const auto& position : published_positions()) {
    const CartesianImpedance arm = typical_subject(position).impedance;
    const Eigen::Vector2d values = arm.M.selfadjointView<Eigen::Lower>().eigenvalues();
    EXPECT_GT(values[0], 0.2);
    EXPECT_LT(values[1], 4.0);
  }
}

TEST(ArmModel, RefusesAPositionOutOfReach) {
  const auto result = forward_model(typical_arm(), {}, {}, {0.5, 0.5});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(result.error().message.find("expected 0.05"), std::string::npos) << result.error().message;
}

TEST(ArmModel, FindsRadiiFromMassAndCircumference) {
  EXPECT_NEAR(radius_from_circumference(0.3), 0.3 / (2.0 * std::numbers::pi), 1e-15);
  const double r = radius_from_mass(1.5, 0.35);
  EXPECT_NEAR(kLimbDensity * std::numbers::pi * r * r * 0.35, 1.5, 1e-12);
}

TEST(CoriolisCheck, IsOneToTwoOrdersBelowDampingAtThePublishedSpeed) {
  // Published for 0.8 m/s: one to two orders of magnitude smaller than B X'. Its scale is v^2, against v.
  const SimulatedArm subject = typical_subject();
  const auto slow = coriolis_check(typical_arm(), {0.0, 0.38}, subject.impedance.B, 0.08).value();
  const auto fast = coriolis_check(typical_arm(), {0.0, 0.38}, subject.impedance.B, 0.8).value();
  EXPECT_LT(slow.share, 0.03);
  EXPECT_NEAR(fast.coriolis_force / slow.coriolis_force, 100.0, 1e-6);
  EXPECT_NEAR(fast.share / slow.share, 10.0, 1e-6);
  EXPECT_TRUE(std::isinf(coriolis_check(typical_arm(), {0.0, 0.38}, Eigen::Matrix2d::Zero(), 0.8)->share));
}

}  // namespace
}  // namespace tonus::impedance::test
