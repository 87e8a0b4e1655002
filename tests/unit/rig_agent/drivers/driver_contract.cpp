#include "tests/unit/rig_agent/drivers/driver_contract.hpp"

#include <cmath>
#include <limits>

#include "rig_agent/control/auxiliary_collector.hpp"

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
    EXPECT_NE(result.error().message.find("is not allowed; expected"), std::string::npos)
        << result.error().message;
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

namespace {

/// Cycles to a sample of the highest sample rate that all channels' rates are whole multiples of; 0: none up
/// to 1000.
unsigned divider_for(std::span<const AuxiliaryChannel> channels, double loop_rate) {
  for (unsigned divider = 1; divider <= 1000; ++divider) {
    if (validate(channels, loop_rate / divider)) return divider;
  }
  return 0;
}

}  // namespace

TEST_P(DriverContract, GivesEveryAuxiliaryChannelAsItDeclaresIt) {
  activate();
  const auto channels = driver_->auxiliary_channels();
  if (channels.empty()) return;
  const unsigned divider = divider_for(channels, 1.0 / kPeriod);
  ASSERT_NE(divider, 0U) << "no sample rate suits these channels: "
                         << validate(channels, 1.0 / kPeriod).error().message;
  control::AuxiliaryCollector collector(channels, 1.0 / kPeriod / divider, divider);
  constexpr std::uint64_t kSamples = 20;
  std::vector<std::size_t> measured(channels.size());
  for (std::uint64_t cycle = 0; cycle <= kSamples * divider && cycle < 150; ++cycle) {
    Reading reading;
    ASSERT_EQ(driver_->read(reading), DriverStatus::kOk);
    ASSERT_EQ(driver_->write({0.0, 0.0}), DriverStatus::kOk);
    collector.collect(*driver_, cycle, true);
    if (cycle % divider != 0) continue;
    std::size_t place = 0;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      const auto count = values_per_sample(channels[i], 1.0 / kPeriod / divider);
      for (std::uint32_t k = 0; k < count; ++k)
        measured[i] += std::isfinite(collector.row()[place++]) ? 1 : 0;
    }
    collector.begin_sample();
  }
  for (std::size_t i = 0; i < channels.size(); ++i)
    EXPECT_GT(measured[i], 0U) << channels[i].name << " is declared and never measured";
}

TEST_P(DriverContract, GivesNoAuxiliaryValuesUntilItIsActive) {
  ASSERT_TRUE(driver_->configure(kPeriod));
  const std::vector<std::uint32_t> counts(driver_->auxiliary_channels().size(), 1);
  std::vector<float> values(counts.size(), std::numeric_limits<float>::quiet_NaN());
  if (!counts.empty()) driver_->read_auxiliary(counts, values);
  for (const float value : values) EXPECT_TRUE(std::isnan(value));
}

TEST_P(DriverContract, MarksTheOnsetIfItSaysThatItDoes) {
  activate();
  EXPECT_EQ(driver_->set_onset(true), driver_->capabilities().marks_onset);
  EXPECT_EQ(driver_->set_onset(false), driver_->capabilities().marks_onset);
}

}  // namespace tonus::drivers
