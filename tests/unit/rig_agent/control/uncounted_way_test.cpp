#include "rig_agent/control/uncounted_way.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <optional>

namespace tonus::control {
namespace {

constexpr double kPeriod = 0.001;
constexpr double kLimit = 2.0;  // N m, as SafetyLimits has it

/// A manipulandum of 1 kg m2 at each joint that is told torques and loads.
class UncountedWayTest : public ::testing::Test {
 protected:
  UncountedWayTest() {
    geometry_.counts_per_unit = {1273.0, 1273.0};
    friction_.coulomb = {0.03, 0.03};
    limits_.unexplained_torque = kLimit;
    begin();
  }

  void begin() {
    way_.emplace(limits_, friction_, geometry_, kPeriod);
    way_->begin_trial(counts_);
  }

  /// After how many cycles it is found; 0 for never.
  int found_after(const Eigen::Vector2d& unexplained, int cycles, const Eigen::Vector2d& load = {0.0, 0.0}) {
    for (int i = 1; i <= cycles; ++i) {
      if (way_->check(counts_, unexplained, load, {1.0, 1.0})) return i;
    }
    return 0;
  }

  SafetyLimits limits_;
  JointFriction friction_;
  RigGeometry geometry_;
  std::array<double, 2> counts_{100.0, 200.0};
  std::optional<UncountedWay> way_;
};

/// 1 N m, less what friction and errors may take (0.3 + 0.09), turns 1 kg m2 by 12 mrad in 0.2 s:
/// sqrt(2 * 0.012 / 0.61) = 0.198 s.
TEST_F(UncountedWayTest, ATorqueThatWouldHaveTurnedTheJointIsFoundInTheTimeThatTheWayTakes) {
  EXPECT_NEAR(found_after({0.0, 1.0}, 1000), 198, 3);
}

TEST_F(UncountedWayTest, FrictionOfThreeTimesTheModelsIsNoFault) {
  EXPECT_EQ(found_after({0.09, -0.09}, 60'000), 0);
}

TEST_F(UncountedWayTest, ForcesThatAreOffByAShareOfAHeavyLoadAreNoFault) {
  EXPECT_EQ(found_after({0.5, 0.5}, 60'000, {4.0, -4.0}), 0);
}

TEST_F(UncountedWayTest, AJointThatCountsIsNoFault) {
  for (int i = 0; i < 10'000; ++i) {
    if (i % 50 == 0) counts_[0] += 1.0;
    ASSERT_EQ(found_after({1.5, 0.0}, 1), 0) << i;
  }
}

TEST_F(UncountedWayTest, ATorqueThatChangesItsSignIsNoFault) {
  for (int i = 0; i < 10'000; ++i) ASSERT_EQ(found_after({std::sin(0.03 * i), 0.0}, 1), 0) << i;
}

/// The inertia that couples the joints is known to a third.
TEST_F(UncountedWayTest, TheOtherJointsMotionAllowsForMore) {
  const int alone = found_after({0.0, 1.0}, 1000);
  begin();
  int beside = 0;
  for (int i = 1; i <= 1000 && beside == 0; ++i) {
    counts_[0] += i % 4 == 0 ? 1.0 : 0.0;
    if (found_after({0.0, 1.0}, 1) != 0) beside = i;
  }
  EXPECT_GT(beside, alone);
}

TEST_F(UncountedWayTest, ACoarseEncoderIsGivenSomeCounts) {
  geometry_.counts_per_unit = {50.0, 50.0};  // 20 mrad a count: 4 of them are 80 mrad
  begin();
  EXPECT_NEAR(found_after({0.0, 1.0}, 2000), std::sqrt(2.0 * 0.080 / 0.61) / kPeriod, 5.0);
}

TEST_F(UncountedWayTest, AWiderLimitAllowsForMore) {
  limits_.unexplained_torque = 10.0;  // a rig whose law knows it badly
  begin();
  EXPECT_EQ(found_after({1.0, 1.0}, 60'000), 0);
}

}  // namespace
}  // namespace tonus::control
