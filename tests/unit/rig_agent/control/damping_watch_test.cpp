#include "rig_agent/control/damping_watch.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace tonus::control {
namespace {

constexpr double kPeriod = 0.001;
constexpr double kObserver = 40.0;  // rad/s
constexpr double kInertia = 0.8;    // kg m2, each joint

/// Both joints alike, each with its own damping that the motor really gives (N m s/rad, negative where it
/// drives), and an arm that pulls with stiffness and push. The watch sees rates as the observer has them.
class DampingWatchTest : public ::testing::Test {
 protected:
  struct Motion {
    double rate = 0.3;       // rad/s, at the start
    double damping = 1.0;    // N m s/rad
    double stiffness = 0.0;  // N m/rad, of the arm
    double push = 0.0;       // N m, by the hand
    double sensor = 1.0;     // what the force sensor says of the force
    double inertia = 1.0;    // what the law knows, over the true one
  };

  /// Cycles until damping ended; -1: it did not in `cycles`.
  int run(const Motion& motion, int cycles = 3000) {
    double angle = 0.0;
    double rate = motion.rate;
    double acceleration_once = 0.0;
    double acceleration_seen = 0.0;
    double rate_seen = rate;
    const double share = 1.0 - std::exp(-kObserver * kPeriod);
    for (int i = 0; i < cycles; ++i) {
      const double load = motion.stiffness * angle - motion.push;
      const Eigen::Vector2d loads = Eigen::Vector2d::Constant(motion.sensor * load);
      const Eigen::Matrix2d mass = motion.inertia * kInertia * Eigen::Matrix2d::Identity();
      if (!watch_.takes_energy(mass, Eigen::Vector2d::Constant(rate_seen), loads)) return i;
      const double acceleration = (-motion.damping * rate_seen - load) / kInertia;
      rate += kPeriod * acceleration;
      angle += kPeriod * rate;
      acceleration_once += share * (acceleration - acceleration_once);
      acceleration_seen += share * (acceleration_once - acceleration_seen);
      rate_seen += kPeriod * acceleration_seen;
    }
    return -1;
  }

  DampingWatch watch_{kObserver, kPeriod};
};

TEST_F(DampingWatchTest, AHandleThatSlowsDownIsDampedToTheEnd) { EXPECT_EQ(run({}), -1); }

TEST_F(DampingWatchTest, AnArmThatRingsIsDampedToTheEnd) {
  for (const double stiffness : {5.0, 50.0, 200.0}) {
    for (const double off : {0.8, 1.0, 1.2}) {
      watch_.begin();
      EXPECT_EQ(run({.stiffness = stiffness, .inertia = off}), -1) << stiffness << ", " << off;
      watch_.begin();
      EXPECT_EQ(run({.stiffness = stiffness, .sensor = off}), -1) << stiffness << ", " << off;
    }
  }
}

TEST_F(DampingWatchTest, AHandThatPushesIsDampedWhileTheForceSensorShowsIt) {
  EXPECT_EQ(run({.rate = 0.0, .push = 3.0}), -1);
}

/// What the rule costs: without a force sensor a push looks like a torque that drives.
TEST_F(DampingWatchTest, AHandThatPushesUnseenEndsTheDamping) {
  EXPECT_GE(run({.rate = 0.0, .push = 3.0, .sensor = 0.0}), 0);
}

TEST_F(DampingWatchTest, AMotorThatGivesLessThanItIsAskedForStillDamps) {
  EXPECT_EQ(run({.damping = 0.2}), -1);
  watch_.begin();
  EXPECT_EQ(run({.damping = 0.2, .stiffness = 50.0}), -1);
}

/// Kinetic energy grows by exp(2 t / 0.8 s): by half in 0.2 s.
TEST_F(DampingWatchTest, DampingUnderWhichTheMotionGrowsEndsWhenItsEnergyHasGrownByHalf) {
  const int ended = run({.damping = -1.0});
  EXPECT_GT(ended, 0);
  EXPECT_LT(ended, 350);
}

TEST_F(DampingWatchTest, DampingThatDrivesAnArmIsEndedToo) {
  EXPECT_GT(run({.damping = -1.0, .stiffness = 50.0}), 0);
}

TEST_F(DampingWatchTest, DampingThatWasEndedStaysEndedUntilItIsBegunAnew) {
  ASSERT_GT(run({.damping = -1.0}), 0);
  EXPECT_EQ(run({}), 0);
  watch_.restart();
  EXPECT_EQ(run({}), 0);
  watch_.begin();
  EXPECT_EQ(run({}), -1);
}

TEST_F(DampingWatchTest, AnObserverThatStartsAnewInAMotionIsNoGrowth) {
  watch_.restart();
  double rate = 0.0;
  for (int i = 0; i < 1000; ++i) {
    rate += 0.04 * (0.3 * std::exp(-0.001 * i) - rate);  // It learns of 0.3 rad/s, which damping takes.
    EXPECT_TRUE(watch_.takes_energy(kInertia * Eigen::Matrix2d::Identity(), Eigen::Vector2d::Constant(rate),
                                    Eigen::Vector2d::Zero()))
        << i;
  }
}

TEST_F(DampingWatchTest, AMotionThatIsNoNumberEndsTheDamping) {
  EXPECT_EQ(run({.rate = std::nan("")}), static_cast<int>(std::lround(DampingWatch::kSettling / kPeriod)));
}

}  // namespace
}  // namespace tonus::control
