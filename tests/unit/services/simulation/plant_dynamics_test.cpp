#include <Eigen/LU>
#include <cmath>
#include <gtest/gtest.h>

#include "rig_agent/control/validation.hpp"
#include "services/simulation/plant.hpp"
#include "services/simulation/true_impedance.hpp"

namespace tonus::simulation {
namespace {

constexpr double kPeriod = 0.001;

// Nothing dissipates, and the hand is seated `offset` (m) off its spring centre.
PlantProfile lossless_profile() {
  PlantProfile profile;
  profile.manipulandum.friction = {{0.0, 0.0}, {0.0, 0.0}, 0.02};
  profile.grip.damping = 0.0;
  profile.subject.damping = {0.0, 0.0, 0.0};
  return profile;
}

void displace(Plant& plant, const PlantProfile& profile, const Eigen::Vector2d& offset) {
  ShoulderPose shoulder;
  shoulder.angle = 0.3;
  shoulder =
      control::shoulder_for(profile.manipulandum.home - offset, profile.subject.posture, shoulder.angle);
  plant.seat(shoulder, profile.subject.posture);
}

// State at the end of a second of ringing under a torque that changes, with n steps a period.
PlantState state_after_a_second(unsigned sub_steps) {
  PlantProfile profile;
  profile.sub_steps = sub_steps;
  Plant plant(profile, kPeriod);
  displace(plant, profile, {0.008, -0.006});
  for (int i = 0; i < 1000; ++i) {
    const double t = i * kPeriod;
    plant.step({0.8 * std::sin(17.0 * t), -0.5 * std::cos(11.0 * t)});
  }
  return plant.state();
}

double difference(const PlantState& a, const PlantState& b) {
  return std::sqrt((a.q - b.q).squaredNorm() + (a.t - b.t).squaredNorm());
}

TEST(PlantIntegration, ConvergesWithTheFourthPowerOfTheStep) {
  const PlantState finest = state_after_a_second(48);
  const double coarse = difference(state_after_a_second(3), finest);
  const double half = difference(state_after_a_second(6), finest);
  const double quarter = difference(state_after_a_second(12), finest);
  EXPECT_LT(coarse, 1e-8) << "rad, after 1 s with the default step: far below an encoder step of 8e-4 rad";
  EXPECT_GT(coarse / half, 10.0);  // 16 in the limit.
  EXPECT_GT(half / quarter, 10.0);
}

TEST(PlantEnergy, IsKeptWhenNothingDissipates) {
  PlantProfile profile = lossless_profile();
  profile.sub_steps = 16;
  Plant plant(profile, kPeriod);
  displace(plant, profile, {0.03, -0.02});
  const double start = plant.energy();
  ASSERT_GT(start, 0.05);
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    plant.step(Eigen::Vector2d::Zero());
    worst = std::max(worst, std::abs(plant.energy() - start));
  }
  EXPECT_LT(worst, 1e-6 * start);
}

TEST(PlantEnergy, IsKeptByASpinningManipulandumSoThatTheCoriolisTermsAreRight) {
  // The hand is open: both chains swing freely and far, the arm on its joint springs.
  PlantProfile profile = lossless_profile();
  profile.sub_steps = 4;
  profile.subject.letting_go = {true, 0.0, 1e6};
  Plant plant(profile, kPeriod);
  displace(plant, profile, {0.03, 0.03});
  for (int i = 0; i < 500; ++i) plant.step({8.0, -3.0});
  plant.step(Eigen::Vector2d::Zero());
  for (int i = 0; i < 20; ++i) plant.step(Eigen::Vector2d::Zero());  // Until the motors' torque is gone.
  ASSERT_GT(plant.state().q_rate.norm(), 1.0);
  const double start = plant.energy();
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    plant.step(Eigen::Vector2d::Zero());
    worst = std::max(worst, std::abs(plant.energy() - start));
  }
  EXPECT_LT(worst, 1e-5 * start);
}

TEST(PlantEnergy, OnlyFallsWhenNobodyDrives) {
  const PlantProfile profile;
  Plant plant(profile, kPeriod);
  displace(plant, profile, {0.02, 0.01});
  double before = plant.energy();
  const double start = before;
  for (int i = 0; i < 3000; ++i) {
    plant.step(Eigen::Vector2d::Zero());
    ASSERT_LE(plant.energy(), before * (1.0 + 1e-9));
    before = plant.energy();
  }
  EXPECT_LT(before, 0.1 * start);
}

TEST(PlantClosedForm, SpinsAFreeRotorThroughTheMotorsLag) {
  // Weightless links, the hand open: joint 2 alone is I w' = T (1 - exp(-t / c)), so with joint 1 held back
  // by the same torque on its rotor, the outer link's angle is (T / I) (t^2 / 2 - c t + c^2 (1 - exp(-t /
  // c))).
  PlantProfile profile;
  profile.manipulandum.link_masses = {0.0, 0.0};
  profile.manipulandum.elbow_motor_mass = 0.0;
  profile.manipulandum.tip_mass = 0.0;
  profile.manipulandum.friction = {{0.0, 0.0}, {0.0, 0.0}, 0.02};
  profile.manipulandum.motor_time_constant = 0.004;
  profile.sensors.handle_mass = 0.0;
  profile.subject.letting_go = {true, 0.0, 1e6};
  Plant plant(profile, kPeriod);
  const double inertia = profile.manipulandum.rotor_inertias[1];
  const Eigen::Vector2d start = plant.state().q;
  const double torque = 0.5;
  for (int i = 1; i <= 500; ++i) {
    plant.step({torque, torque});  // Joint 1's rotor feels T - T = 0.
    const double t = i * kPeriod;
    const double c = profile.manipulandum.motor_time_constant;
    const double angle = torque / inertia * (0.5 * t * t - c * t + c * c * (1.0 - std::exp(-t / c)));
    ASSERT_NEAR(plant.state().q[1] - start[1], angle, 1e-10);
    ASSERT_NEAR(plant.state().q[0] - start[0], 0.0, 1e-12);
  }
}

TEST(PlantClosedForm, RingsAFreeArmAsOneAxisWhenItsMatricesAreProportional) {
  // K = w^2 I and B = 2 z w I at the posture: for small angles every joint follows one and the same damped
  // cosine.
  PlantProfile profile;
  const double w = 12.0;
  const double z = 0.15;
  const Eigen::Vector2d posture = profile.subject.posture;
  const Eigen::Vector2d angles = profile.subject.links.angles_at(posture);
  const Eigen::Matrix2d inertia = cylinder_inertia(profile.subject).mass_matrix(std::cos(angles[1]));
  const auto scaled = [&](double by) {
    return JointImpedance{by * (inertia(0, 0) - inertia(0, 1)), by * (inertia(1, 1) - inertia(0, 1)),
                          by * inertia(0, 1)};
  };
  profile.subject.stiffness = scaled(w * w);
  profile.subject.damping = scaled(2.0 * z * w);
  profile.subject.letting_go = {true, 0.0, 1e6};
  Plant plant(profile, kPeriod);
  displace(plant, profile, {1e-5, -2e-5});
  const Eigen::Vector2d start = plant.state().t - angles;
  ASSERT_GT(start.norm(), 1e-6);
  const double wd = w * std::sqrt(1.0 - z * z);
  for (int i = 1; i <= 1000; ++i) {
    plant.step(Eigen::Vector2d::Zero());
    const double t = i * kPeriod;
    const double share = std::exp(-z * w * t) * (std::cos(wd * t) + z * w / wd * std::sin(wd * t));
    ASSERT_LT((plant.state().t - angles - share * start).norm(), 2e-4 * start.norm()) << "at " << t << " s";
  }
}

TEST(PlantClosedForm, SettlesWhereForceAndArmStiffnessBalance) {
  // A steady force of the handle: x = K^-1 f for small displacements, K by the forward model.
  PlantProfile profile;
  profile.manipulandum.friction.coulomb = {0.0, 0.0};
  Plant plant(profile, kPeriod);
  const Eigen::Vector2d posture = profile.subject.posture;
  plant.seat(control::shoulder_for(profile.manipulandum.home, posture), posture);
  const Eigen::Vector2d f(0.02, -0.03);
  for (int i = 0; i < 20'000; ++i) {
    plant.step(profile.manipulandum.links.jacobian(plant.state().q).transpose() * f);
  }
  const Eigen::Vector2d expected = true_impedance(profile.subject, posture).stiffness.inverse() * f;
  EXPECT_LT((plant.handle() - profile.manipulandum.home - expected).norm(), 0.005 * expected.norm());
  EXPECT_LT((plant.flexure_force() - f).norm(), 1e-4);
}

TEST(PlantMotor, ClipsTheTorqueAtItsLimit) {
  PlantProfile profile;
  profile.manipulandum.torque_limits = {0.5, 0.5};
  Plant plant(profile, kPeriod);
  for (int i = 0; i < 50; ++i) plant.step({100.0, -100.0});
  EXPECT_NEAR(plant.state().motor[0], 0.5, 1e-6);
  EXPECT_NEAR(plant.state().motor[1], -0.5, 1e-6);
}

TEST(JointFriction, OpposesTheMotionWithItsViscousAndItsDryShare) {
  const control::JointFriction friction{{0.05, 0.1}, {0.03, 0.02}, 0.02};
  const Eigen::Vector2d fast = friction.torque({10.0, -10.0});
  EXPECT_NEAR(fast[0], 0.5 + 0.03, 1e-6);
  EXPECT_NEAR(fast[1], -1.0 - 0.02, 1e-6);
  EXPECT_EQ(friction.torque({0.0, 0.0}), Eigen::Vector2d::Zero());
}

}  // namespace
}  // namespace tonus::simulation
