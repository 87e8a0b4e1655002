#include "rig_agent/control/plausibility.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace tonus::control {
namespace {

/// One healthy cycle after the other of a trial, which a test spoils.
class PlausibilityTest : public ::testing::Test {
 protected:
  PlausibilityTest() {
    RigGeometry geometry;
    geometry.kind = RigKind::kTwoLink;
    geometry.links = {0.30, 0.35};
    geometry.counts_per_unit = {1273.0, 1273.0};
    checked_ = std::make_unique<Plausibility>(limits_, ServoGains{}, JointFriction{}, geometry, 0.001);
    input_.is_in_trial = true;
  }

  FaultBits step(int cycles = 1) {
    FaultBits found = 0;
    for (int i = 0; i < cycles; ++i) found |= checked_->check(input_);
    return found;
  }

  SafetyLimits limits_;
  PlausibilityInput input_;
  std::unique_ptr<Plausibility> checked_;
};

TEST_F(PlausibilityTest, AHandAtRestIsPlausible) { EXPECT_EQ(step(10'000), 0U); }

TEST_F(PlausibilityTest, ALoadThatChangesWithoutACountIsAnEncoderThatStandsStill) {
  step();
  input_.load = {2.5, 0.0};
  EXPECT_EQ(step(50), 0U) << "a heavy handle takes its time";
  EXPECT_EQ(step(2), bit(Fault::kEncoderStill));
}

TEST_F(PlausibilityTest, ALoadOnAJointThatMovesIsPlausible) {
  for (int i = 0; i < 1000; ++i) {
    input_.load.x() += 0.01;
    input_.raw.force_V = {0.001 * i, -0.001 * i};
    if (i % 20 == 0) input_.raw.encoder_count[0] += 1;
    ASSERT_EQ(step(), 0U) << i;
  }
}

TEST_F(PlausibilityTest, TorqueThatTheModelCannotExplainIsAnEncoderThatIsWrong) {
  input_.raw.encoder_count[1] = 5;
  input_.unexplained = {0.0, -2.1};
  EXPECT_EQ(step(), bit(Fault::kEncoderReversed));
}

TEST_F(PlausibilityTest, AForceChannelThatSaysNothingWhileTheHandleMovesIsDead) {
  step();
  for (int i = 0; i < 8; ++i) {
    input_.raw.encoder_count[0] += 1;
    input_.raw.force_V[1] += 0.001;
    step();
  }
  EXPECT_EQ(checked_->check(input_), 0U) << "in so short a time it may be chance";
  EXPECT_EQ(step(30), bit(Fault::kForceStill));
}

TEST_F(PlausibilityTest, AnArmThatGivesBackWorkInTheFirstMomentsHasAReversedSensor) {
  input_.is_perturbing = true;
  input_.is_onset = true;
  step();
  input_.is_onset = false;
  FaultBits found = 0;
  for (int i = 0; i < 149; ++i) {
    input_.velocity = {0.05, 0.0};
    input_.force = {-2.0, 0.0};
    input_.raw.force_V[0] -= 0.001;
    input_.raw.force_V[1] -= 0.001;
    found |= step();
  }
  EXPECT_EQ(found, bit(Fault::kForceAgainstMotion));
}

TEST_F(PlausibilityTest, AnArmThatHelpsAlongLaterIsPlausible) {
  input_.is_perturbing = true;
  input_.is_onset = true;
  step();
  input_.is_onset = false;
  step(150);
  input_.velocity = {0.05, 0.0};
  input_.force = {-2.0, 0.0};
  EXPECT_EQ(step(500), 0U);
}

TEST_F(PlausibilityTest, MoreEnergyThanAllowedInATrialIsFoundAndANewTrialBeginsAtZero) {
  input_.velocity = {0.5, 0.0};
  input_.force = {20.0, 0.0};
  EXPECT_EQ(step(299), 0U);
  EXPECT_EQ(step(3), bit(Fault::kEnergy));
  input_.is_in_trial = false;
  EXPECT_EQ(step(), 0U);
  input_.is_in_trial = true;
  EXPECT_EQ(step(299), 0U);
}

TEST_F(PlausibilityTest, LimitsThatAreOffFindNothing) {
  limits_.unexplained_torque = 0.0;
  limits_.trial_energy = 0.0;
  checked_ = std::make_unique<Plausibility>(limits_, ServoGains{}, JointFriction{}, RigGeometry{}, 0.001);
  input_.unexplained = {100.0, 100.0};
  input_.velocity = {0.5, 0.0};
  input_.force = {20.0, 0.0};
  EXPECT_EQ(step(10'000), 0U);
}

}  // namespace
}  // namespace tonus::control
