#include "rig_agent/drivers/simulated.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "rig_agent/control/validation.hpp"

namespace tonus::drivers {
namespace {

class SimulatedDriver : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(driver_.configure(0.001));
    ASSERT_TRUE(driver_.activate());
  }
  Reading cycle(const Eigen::Vector2d& torque = Eigen::Vector2d::Zero()) {
    Reading reading;
    EXPECT_EQ(driver_.read(reading), DriverStatus::kOk);
    EXPECT_EQ(driver_.write(torque), DriverStatus::kOk);
    return reading;
  }
  static TrialNotice notice(const Eigen::Vector2d& home, const Eigen::Vector2d& posture) {
    return {control::shoulder_for(home, posture), posture, 0};
  }

  Simulated driver_{simulation::Profile{}};
};

TEST_F(SimulatedDriver, AdvancesItsClockByOnePeriodWithEveryWrite) {
  for (int i = 0; i < 5; ++i) EXPECT_EQ(cycle().raw.acquisition_ns, i * 1'000'000);
}

TEST_F(SimulatedDriver, StandsStillWithTheHandAtItsSpringCentre) {
  const auto counts = cycle().raw.encoder_count;
  for (int i = 0; i < 500; ++i) cycle();
  EXPECT_EQ(cycle().raw.encoder_count, counts);
}

TEST_F(SimulatedDriver, SeatsTheSubjectWhereTheTrialSays) {
  // The posture 8 mm beside the handle: the arm pulls the handle there.
  const Eigen::Vector2d home(0.30, 0.35);
  driver_.begin_trial(notice(home + Eigen::Vector2d(0.008, 0.0), {0.0, 0.52}));
  for (int i = 0; i < 20'000; ++i) cycle();
  RigGeometry geometry = driver_.geometry();
  const Eigen::Vector2d handle = geometry.links.endpoint(joint_coordinates(geometry, cycle().raw));
  EXPECT_NEAR(handle.x(), 0.308, 0.001);
  EXPECT_NEAR(handle.y(), 0.350, 0.001);
}

TEST_F(SimulatedDriver, LeavesASeatedSubjectInMotionWhenTheNextTrialIsAtTheSamePlace) {
  Simulated other{simulation::Profile{}};
  ASSERT_TRUE(other.configure(0.001));
  ASSERT_TRUE(other.activate());
  const TrialNotice seat = notice({0.305, 0.352}, {0.0, 0.38});
  driver_.begin_trial(seat);
  other.begin_trial(seat);
  Reading reading;
  for (int i = 0; i < 300; ++i) {
    if (i == 100) driver_.begin_trial(seat);
    const Reading here = cycle({0.1, 0.1});
    ASSERT_EQ(other.read(reading), DriverStatus::kOk);
    ASSERT_EQ(other.write({0.1, 0.1}), DriverStatus::kOk);
    ASSERT_EQ(here.raw.encoder_count, reading.raw.encoder_count);
    ASSERT_EQ(here.raw.force_V, reading.raw.force_V);
  }
}

TEST_F(SimulatedDriver, ShowsTheFaultsThatATestAsksFor) {
  const auto counts = cycle().raw.encoder_count;
  driver_.disturb({false, true, {40.0, 0.0}, {0.0, -50.0}});
  const Reading disturbed = cycle();
  EXPECT_TRUE(disturbed.is_emergency_stop_pressed);
  EXPECT_EQ(disturbed.raw.encoder_count[0], counts[0] + 40.0);
  EXPECT_EQ(disturbed.raw.force_V[1], -10.0);
  driver_.disturb({true, false, {}, {}});
  Reading reading;
  EXPECT_EQ(driver_.read(reading), DriverStatus::kDisconnected);
  driver_.disturb({});
  EXPECT_EQ(cycle().raw.encoder_count, counts);
}

}  // namespace
}  // namespace tonus::drivers
