#include "rig_agent/control/sign_check.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "rig_agent/control/servo.hpp"

namespace tonus::control {
namespace {

constexpr double kPeriod = 0.001;

/// What the observer leaves of a torque that it did not predict.
class Observer {
 public:
  Eigen::Vector2d pass(const Eigen::Vector2d& torque) {
    const double w = 1.0 - std::exp(-ServoGains{}.observer_frequency * kPeriod);
    once_ += w * (torque - once_);
    twice_ += w * (once_ - twice_);
    left_ += (1.0 - std::exp(-kUnexplainedFilter * kPeriod)) * (twice_ - left_);
    return left_;
  }

 private:
  Eigen::Vector2d once_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d twice_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d left_ = Eigen::Vector2d::Zero();
};

/// Two seconds of a hand that is pushed to and fro: both channels of the force sensor say something.
class SignCheckTest : public ::testing::Test {
 protected:
  struct Share {
    double channel = 0.0;   ///< 1 - g of the first channel.
    double encoder = 0.0;   ///< c of the second encoder: 2 for one that counts backwards.
    double inertia = 0.0;   ///< What the model of the inertia is off by.
    double friction = 0.0;  ///< N m at the first joint, against the motion, that the model does not know.
  };

  static SignCheck::Reversed found(const Share& share) {
    JointFriction friction;
    friction.coulomb = {0.05, 0.05};
    SignCheck test({}, friction, kPeriod);
    Observer observer;
    SignCheck::Reversed found;
    for (int i = 0; i < 2000; ++i) {
      const double t = i * kPeriod;
      Eigen::Matrix2d loads;
      loads << 0.5 * std::sin(9.0 * t), 0.1 * std::cos(14.0 * t), 0.0, 0.3 * std::sin(14.0 * t);
      Eigen::Matrix2d accelerations;
      accelerations << 0.4 * std::cos(9.0 * t), 0.1 * std::sin(20.0 * t), 0.1 * std::cos(9.0 * t),
          0.4 * std::sin(20.0 * t);
      Eigen::Vector2d wrong = share.channel * loads.col(0) + share.inertia * accelerations.rowwise().sum();
      wrong.x() += std::copysign(share.friction, std::cos(9.0 * t));
      wrong += share.encoder * accelerations.col(1);
      const auto now = test.check(observer.pass(wrong), loads, accelerations);
      found.is_channel |= now.is_channel;
      found.is_encoder |= now.is_encoder;
    }
    return found;
  }
  static bool is_found_reversed(const Share& share) { return found(share).is_channel; }
};

TEST_F(SignCheckTest, GoodChannelsAndEncodersAreFoundGood) {
  EXPECT_FALSE(found({}).is_channel);
  EXPECT_FALSE(found({}).is_encoder);
}

TEST_F(SignCheckTest, AnEncoderThatCountsBackwardsIsFound) {
  for (const double off : {-0.2, 0.0, 0.2}) {
    const auto seen = found({.encoder = 2.0, .inertia = off});
    EXPECT_TRUE(seen.is_encoder) << off;
    EXPECT_FALSE(seen.is_channel) << off;
  }
}

/// However heavy the rig is, its inertia leaves less than 1.
TEST_F(SignCheckTest, NoInertiaLooksLikeAnEncoderThatCountsBackwards) {
  for (const double off : {-2.0, -0.9, -0.25, 0.25, 0.9, 1.0})
    EXPECT_FALSE(found({.inertia = off}).is_encoder) << off;
}

TEST_F(SignCheckTest, AReversedForceChannelIsNoEncoder) {
  EXPECT_FALSE(found({.channel = 2.0, .inertia = 0.2}).is_encoder);
}

TEST_F(SignCheckTest, AReversedForceChannelIsFound) { EXPECT_TRUE(is_found_reversed({.channel = 2.0})); }

TEST_F(SignCheckTest, AReversedForceChannelIsFoundBesideAModelThatIsOff) {
  EXPECT_TRUE(is_found_reversed({.channel = 2.0, .inertia = 0.2}));
}

TEST_F(SignCheckTest, FrictionThatTakesUpALoadWholeIsNoFault) {
  EXPECT_FALSE(is_found_reversed({.channel = 1.0}));
}

TEST_F(SignCheckTest, AModelThatIsWrongIsNoFault) {
  for (const double off : {-2.0, -0.9, -0.25, 0.25, 0.9, 2.0})
    EXPECT_FALSE(is_found_reversed({.inertia = off})) << off;
}

TEST_F(SignCheckTest, FrictionThatTheModelDoesNotKnowIsNoFault) {
  EXPECT_FALSE(is_found_reversed({.friction = 0.1}));
}

}  // namespace
}  // namespace tonus::control
