#include "rig_agent/control/force_sign_check.hpp"

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
class ForceSignCheckTest : public ::testing::Test {
 protected:
  struct Share {
    double channel = 0.0;   ///< 1 - g of the first channel.
    double inertia = 0.0;   ///< What the model of the inertia is off by.
    double friction = 0.0;  ///< N m at the first joint, against the motion, that the model does not know.
  };

  static bool is_found_reversed(const Share& share) {
    JointFriction friction;
    friction.coulomb = {0.05, 0.05};
    ForceSignCheck test({}, friction, kPeriod);
    Observer observer;
    bool is_found = false;
    for (int i = 0; i < 2000; ++i) {
      const double t = i * kPeriod;
      Eigen::Matrix2d loads;
      loads << 0.5 * std::sin(9.0 * t), 0.1 * std::cos(14.0 * t), 0.0, 0.3 * std::sin(14.0 * t);
      Eigen::Matrix2d accelerations;
      accelerations << 0.4 * std::cos(9.0 * t), 0.1 * std::sin(20.0 * t), 0.1 * std::cos(9.0 * t),
          0.4 * std::sin(20.0 * t);
      Eigen::Vector2d wrong = share.channel * loads.col(0) + share.inertia * accelerations.rowwise().sum();
      wrong.x() += std::copysign(share.friction, std::cos(9.0 * t));
      is_found |= test.finds_reversed(observer.pass(wrong), loads, accelerations);
    }
    return is_found;
  }
};

TEST_F(ForceSignCheckTest, GoodChannelsAreFoundGood) { EXPECT_FALSE(is_found_reversed({})); }

TEST_F(ForceSignCheckTest, AReversedForceChannelIsFound) { EXPECT_TRUE(is_found_reversed({.channel = 2.0})); }

TEST_F(ForceSignCheckTest, AReversedForceChannelIsFoundBesideAModelThatIsOff) {
  EXPECT_TRUE(is_found_reversed({.channel = 2.0, .inertia = 0.2}));
}

TEST_F(ForceSignCheckTest, FrictionThatTakesUpALoadWholeIsNoFault) {
  EXPECT_FALSE(is_found_reversed({.channel = 1.0}));
}

TEST_F(ForceSignCheckTest, AModelThatIsWrongIsNoFault) {
  for (const double off : {-2.0, -0.9, -0.25, 0.25, 0.9, 2.0})
    EXPECT_FALSE(is_found_reversed({.inertia = off})) << off;
}

TEST_F(ForceSignCheckTest, FrictionThatTheModelDoesNotKnowIsNoFault) {
  EXPECT_FALSE(is_found_reversed({.friction = 0.1}));
}

}  // namespace
}  // namespace tonus::control
