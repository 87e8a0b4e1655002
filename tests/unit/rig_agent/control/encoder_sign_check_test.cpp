#include "rig_agent/control/encoder_sign_check.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "rig_agent/control/observer_response.hpp"

namespace tonus::control {
namespace {

using Causes = UnexplainedCauses;

constexpr double kPeriod = 0.001;

/// Two seconds of a rig with friction of 0.05 N m that is pushed to and fro, with causes as it may have them.
class EncoderSignCheckTest : public ::testing::Test {
 protected:
  /// Torques of one cycle: what the channels say, the torques that were given, and those that they leave for
  /// the acceleration, tau - J^T f = H q".
  struct Cycle {
    Eigen::Matrix2d loads = Eigen::Matrix2d::Zero();
    Eigen::Matrix2d accelerations = Eigen::Matrix2d::Zero();  // -H_k q"_k as columns
    Eigen::Vector2d direction = Eigen::Vector2d::Zero();

    [[nodiscard]] Causes::Columns causes() const {
      const Eigen::Vector2d given = (loads - accelerations).rowwise().sum();
      Causes::Columns columns;
      columns << Eigen::Matrix2d((-given).asDiagonal()), loads, accelerations,
          Eigen::Matrix2d((-direction).asDiagonal());
      return columns;
    }
  };

  static Cycle pushed(double t) {
    Cycle cycle;
    cycle.loads << 0.5 * std::sin(9.0 * t), 0.1 * std::cos(14.0 * t), 0.0, 0.3 * std::sin(14.0 * t);
    cycle.accelerations << 0.4 * std::cos(9.0 * t), 0.1 * std::sin(20.0 * t), 0.1 * std::cos(9.0 * t),
        0.4 * std::sin(20.0 * t);
    cycle.direction = {std::copysign(1.0, std::sin(9.0 * t)), std::copysign(1.0, -std::cos(20.0 * t))};
    return cycle;
  }

  /// An arm that holds against `share` of the torque, 1.2 N m at both joints.
  static Cycle held(double t, double share) {
    Cycle cycle;
    const Eigen::Vector2d given(1.2 * std::sin(9.0 * t), 1.2 * std::sin(13.0 * t));
    cycle.loads.diagonal() = share * given;
    cycle.accelerations.diagonal() = (share - 1.0) * given;
    return cycle;
  }

  template <class Motion>
  static bool is_found(Motion&& motion, const Causes::Numbers& numbers) {
    JointFriction friction;
    friction.coulomb = {0.05, 0.05};
    EncoderSignCheck test(friction, kPeriod);
    ObserverResponse<Causes::kCount> response({}, kPeriod);
    bool found = false;
    for (int i = 0; i < 2000; ++i) {
      const Causes::Columns causes = motion(i * kPeriod).causes();
      if (i == 0) response.start(causes);
      const Causes::Columns& shown = response.pass(causes);
      found |= test.finds_reversed(shown * numbers, shown);
    }
    return found;
  }
  static bool is_found(const Causes::Numbers& numbers) { return is_found(pushed, numbers); }

  /// One cause of joint, channel or encoder k; none of the others.
  static Causes::Numbers only(int cause, double first, double second) {
    Causes::Numbers numbers = Causes::Numbers::Zero();
    numbers.segment<2>(cause) << first, second;
    return numbers;
  }
};

TEST_F(EncoderSignCheckTest, ARigAsTheLawKnowsItIsFoundGood) {
  EXPECT_FALSE(is_found(Causes::Numbers::Zero()));
}

TEST_F(EncoderSignCheckTest, AnEncoderThatCountsBackwardsIsFound) {
  EXPECT_TRUE(is_found(only(Causes::kAccelerations, 2.0, 0.0)));
  EXPECT_TRUE(is_found(only(Causes::kAccelerations, 0.0, 2.0)));
}

TEST_F(EncoderSignCheckTest, AnEncoderThatCountsBackwardsIsFoundBesideAModelThatIsOff) {
  for (const double off : {-0.2, 0.2}) {
    Causes::Numbers numbers = only(Causes::kAccelerations, off, 2.0 + off);
    numbers.segment<2>(Causes::kTorques).setConstant(off);
    numbers.segment<2>(Causes::kFriction).setConstant(0.1);
    EXPECT_TRUE(is_found(numbers)) << off;
  }
}

TEST_F(EncoderSignCheckTest, MotorsOfAnyTorqueAreNoReversedEncoder) {
  for (const double first : {-0.5, 0.0, 0.2, 0.4, 0.6, 0.8})
    for (const double second : {-0.5, 0.0, 0.2, 0.4, 0.6, 0.8})
      EXPECT_FALSE(is_found(only(Causes::kTorques, first, second))) << first << ", " << second;
}

/// g = 2 s - 1, s the share of the torque that the arm holds: g tau - s tau = -(tau - s tau). What is seen is
/// exactly the acceleration of a reversed encoder.
TEST_F(EncoderSignCheckTest, WeakMotorsWhoseArmTurnsTheMotionRoundAreNoReversedEncoder) {
  for (const double gain : {0.2, 0.4, 0.6}) {
    const double share = 0.5 * (1.0 + gain);
    const auto motion = [share](double t) { return held(t, share); };
    EXPECT_FALSE(is_found(motion, only(Causes::kTorques, 1.0 - gain, 1.0 - gain))) << gain;
  }
}

TEST_F(EncoderSignCheckTest, AWeakMotorOfAHeavyRigWithFrictionIsNoReversedEncoder) {
  for (const double inertia : {-0.5, 0.5}) {
    Causes::Numbers numbers = only(Causes::kTorques, 0.6, 0.8);
    numbers.segment<2>(Causes::kAccelerations).setConstant(inertia);
    numbers.segment<2>(Causes::kFriction).setConstant(0.1);
    EXPECT_FALSE(is_found(numbers)) << inertia;
  }
}

/// However heavy the rig is, its inertia leaves less than 1.
TEST_F(EncoderSignCheckTest, NoInertiaLooksLikeAnEncoderThatCountsBackwards) {
  for (const double off : {-2.0, -0.9, -0.25, 0.25, 0.9, 1.0})
    EXPECT_FALSE(is_found(only(Causes::kAccelerations, off, off))) << off;
}

TEST_F(EncoderSignCheckTest, AnEncoderThatStandsStillIsNoReversedOne) {
  EXPECT_FALSE(is_found(only(Causes::kAccelerations, 1.0, 0.0)));
  EXPECT_FALSE(is_found(only(Causes::kAccelerations, 0.0, 1.0)));
}

TEST_F(EncoderSignCheckTest, AReversedForceChannelIsNoReversedEncoder) {
  for (const double off : {0.0, 0.2}) {
    Causes::Numbers numbers = only(Causes::kChannels, 2.0, 0.0);
    numbers.segment<2>(Causes::kAccelerations).setConstant(off);
    EXPECT_FALSE(is_found(numbers)) << off;
  }
}

TEST_F(EncoderSignCheckTest, FrictionThatTheModelDoesNotKnowIsNoReversedEncoder) {
  for (const double torque : {-0.05, 0.1, 0.15})
    EXPECT_FALSE(is_found(only(Causes::kFriction, torque, torque))) << torque;
}

TEST(ObserverResponseTest, AStepIsShownWholeOnceItHasSettled) {
  ObserverResponse<1> response({}, kPeriod);
  response.start(Eigen::Vector2d::Zero());
  EXPECT_FALSE(response.is_settled());
  Eigen::Vector2d shown = Eigen::Vector2d::Zero();
  while (!response.is_settled()) shown = response.pass(Eigen::Vector2d(1.0, -2.0));
  EXPECT_NEAR(shown.x(), 1.0, 0.03);
  EXPECT_NEAR(shown.y(), -2.0, 0.06);
}

}  // namespace
}  // namespace tonus::control
