#include "tests/unit/rig_agent/drivers/driver_contract.hpp"

#include <limits>

namespace tonus::drivers {

TEST_P(DriverContract, FailsToReadAndWriteUntilItIsActive) {
  Reading reading;
  reading.raw.acquisition_ns = 123;
  EXPECT_EQ(driver_->read(reading), DriverStatus::kFailed);
  EXPECT_EQ(driver_->write({0.0, 0.0}), DriverStatus::kFailed);
  EXPECT_FALSE(driver_->activate());
  ASSERT_TRUE(driver_->configure(kPeriod));
  EXPECT_EQ(driver_->read(reading), DriverStatus::kFailed);
  EXPECT_EQ(driver_->write({0.0, 0.0}), DriverStatus::kFailed);
  EXPECT_EQ(reading.raw.acquisition_ns, 123);
}

TEST_P(DriverContract, RefusesAPeriodThatItCannotHaveAndStaysUnconfigured) {
  for (const double period : {0.0, -1.0, 10.0, std::numeric_limits<double>::quiet_NaN()}) {
    const auto result = driver_->configure(period);
    ASSERT_FALSE(result) << period;
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(result.error().message.find("allowed is"), std::string::npos) << result.error().message;
  }
  EXPECT_FALSE(driver_->activate());
}

TEST_P(DriverContract, GivesAConvertibleGeometryOnceConfigured) {
  ASSERT_TRUE(driver_->configure(kPeriod));
  EXPECT_TRUE(validate(driver_->geometry()));
}

TEST_P(DriverContract, GivesIncreasingStampsWhileActive) {
  activate();
  std::int64_t before = std::numeric_limits<std::int64_t>::min();
  for (int i = 0; i < 150; ++i) {
    Reading reading;
    ASSERT_EQ(driver_->read(reading), DriverStatus::kOk);
    ASSERT_GT(reading.raw.acquisition_ns, before);
    before = reading.raw.acquisition_ns;
    ASSERT_EQ(driver_->write({0.1, -0.1}), DriverStatus::kOk);
  }
}

TEST_P(DriverContract, KeepsItsClockGoingWhenActivatedAgain) {
  activate();
  Reading reading;
  for (int i = 0; i < 10; ++i) {
    ASSERT_EQ(driver_->read(reading), DriverStatus::kOk);
    ASSERT_EQ(driver_->write({0.0, 0.0}), DriverStatus::kOk);
  }
  const std::int64_t before = reading.raw.acquisition_ns;
  driver_->deactivate();
  EXPECT_EQ(driver_->read(reading), DriverStatus::kFailed);
  ASSERT_TRUE(driver_->activate());
  driver_->begin_trial(TrialNotice{{{0.30, -0.03}, 0.0}, {0.0, 0.38}, 0});
  ASSERT_EQ(driver_->read(reading), DriverStatus::kOk);
  EXPECT_GT(reading.raw.acquisition_ns, before);
}

TEST_P(DriverContract, RefusesATorqueThatIsNotFinite) {
  activate();
  EXPECT_EQ(driver_->write({std::numeric_limits<double>::quiet_NaN(), 0.0}), DriverStatus::kFailed);
  EXPECT_EQ(driver_->write({0.0, std::numeric_limits<double>::infinity()}), DriverStatus::kFailed);
  EXPECT_EQ(driver_->write({0.0, 0.0}), DriverStatus::kOk);
}

TEST_P(DriverContract, IsNotConfiguredAnewWhileActive) {
  activate();
  EXPECT_FALSE(driver_->configure(kPeriod));
  Reading reading;
  EXPECT_EQ(driver_->read(reading), DriverStatus::kOk);
  driver_->deactivate();
  EXPECT_TRUE(driver_->configure(kPeriod));
}

TEST_P(DriverContract, MayBeDeactivatedInEveryState) {
  driver_->deactivate();
  ASSERT_TRUE(driver_->configure(kPeriod));
  driver_->deactivate();
  ASSERT_TRUE(driver_->activate());
  driver_->deactivate();
  driver_->deactivate();
  EXPECT_TRUE(driver_->activate());
}

TEST_P(DriverContract, IgnoresATrialWhileInactive) {
  driver_->begin_trial({});
  ASSERT_TRUE(driver_->configure(kPeriod));
  driver_->begin_trial({});
  Reading reading;
  EXPECT_EQ(driver_->read(reading), DriverStatus::kFailed);
}

}  // namespace tonus::drivers
