#include "rig_agent/control/sensor_test.hpp"

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

/// Two seconds of a hand that is pushed to and fro: both channels of the force sensor and both joints say
/// something, each of its own.
class SensorTestTest : public ::testing::Test {
 protected:
  struct Share {
    double channel = 0.0;       ///< 1 - g of the first channel.
    double joint = 0.0;         ///< 1 - g of the second joint.
    double inertia = 0.0;       ///< What the model of the inertia is off by.
    double friction = 0.0;      ///< N m at the first joint, against the motion, that the model does not know.
    double channel_size = 0.5;  ///< N m.
  };

  static SensorTest::Finding run(const Share& share) {
    JointFriction friction;
    friction.coulomb = {0.05, 0.05};
    SensorTest test({}, friction, kPeriod);
    Observer observer;
    SensorTest::Finding found;
    for (int i = 0; i < 2000; ++i) {
      const double t = i * kPeriod;
      Eigen::Matrix2d loads;
      loads << share.channel_size * std::sin(9.0 * t), 0.1 * std::cos(14.0 * t), 0.0,
          0.3 * std::sin(14.0 * t);
      Eigen::Matrix2d accelerations;
      accelerations << 0.4 * std::cos(9.0 * t), 0.1 * std::sin(20.0 * t), 0.1 * std::cos(9.0 * t),
          0.4 * std::sin(20.0 * t);
      Eigen::Vector2d wrong = share.channel * loads.col(0) + share.joint * accelerations.col(1) +
                              share.inertia * accelerations.rowwise().sum();
      wrong.x() += std::copysign(share.friction, std::cos(9.0 * t));
      const auto now = test.check(observer.pass(wrong), loads, accelerations);
      found.is_force_wrong |= now.is_force_wrong;
      found.is_encoder_wrong |= now.is_encoder_wrong;
    }
    return found;
  }
};

TEST_F(SensorTestTest, GoodSensorsAreFoundGood) {
  const auto found = run({});
  EXPECT_FALSE(found.is_force_wrong);
  EXPECT_FALSE(found.is_encoder_wrong);
}

TEST_F(SensorTestTest, AReversedForceChannelIsFound) { EXPECT_TRUE(run({.channel = 2.0}).is_force_wrong); }

TEST_F(SensorTestTest, AForceThatNobodyFeelsIsFound) { EXPECT_TRUE(run({.channel = 1.0}).is_force_wrong); }

TEST_F(SensorTestTest, AnEncoderThatStandsStillIsFound) { EXPECT_TRUE(run({.joint = 1.0}).is_encoder_wrong); }

TEST_F(SensorTestTest, AReversedEncoderIsFound) { EXPECT_TRUE(run({.joint = 2.0}).is_encoder_wrong); }

TEST_F(SensorTestTest, AModelThatIsOffByAQuarterIsNoFault) {
  for (const double off : {-0.25, 0.25}) {
    const auto found = run({.inertia = off});
    EXPECT_FALSE(found.is_force_wrong) << off;
    EXPECT_FALSE(found.is_encoder_wrong) << off;
  }
}

TEST_F(SensorTestTest, FrictionThatTakesUpASmallLoadIsNoFault) {
  const auto found = run({.channel = 1.0, .channel_size = 0.1});
  EXPECT_FALSE(found.is_force_wrong);
  EXPECT_FALSE(found.is_encoder_wrong);
}

TEST_F(SensorTestTest, FrictionThatTheModelDoesNotKnowIsNoFault) {
  const auto found = run({.friction = 0.1});
  EXPECT_FALSE(found.is_force_wrong);
  EXPECT_FALSE(found.is_encoder_wrong);
}

}  // namespace
}  // namespace tonus::control
