// A slice of device_fault_campaign.
#include <gtest/gtest.h>

#include "rig_agent/control/fault_text.hpp"
#include "tests/fault/driver/fault_campaign.hpp"

namespace tonus::testing {
namespace {

TEST(FaultyDevice, NeverCarriesTheHandBeyondItsLimitsAndIsNamed) {
  for (std::uint64_t seed = 1000; seed < 1000 + 4 * kDeviceFaults; ++seed) {
    const FaultCase seen = run_fault_case(seed);
    const std::string where = "seed " + std::to_string(seed) + ", " + name_of(seen.fault);
    EXPECT_TRUE(seen.found != 0 || seen.was_harmless) << where;
    EXPECT_LE(seen.way_beyond, 0.005) << where;
    EXPECT_LE(seen.force_share, 1.1) << where;
    EXPECT_LE(seen.cycles_under_torque, 2) << where;
  }
}

/// These were found too late as long as only the size of the unexplained torque was looked at.
TEST(FaultyDevice, EncodersThatCountBackwardsWhileTheArmIsLooseAreFoundInTime) {
  for (const std::uint64_t seed : {500298, 500493, 502128, 502158, 502953, 503328, 504918, 505203}) {
    const FaultCase seen = run_fault_case(seed);
    EXPECT_EQ(seen.fault, DeviceFault::kEncoderReversed);
    EXPECT_NE(seen.found & control::bit(control::Fault::kEncoderReversed), 0U) << seed;
    EXPECT_LE(seen.way_beyond, 0.0) << seed;
    EXPECT_LE(seen.cycles_under_torque, 2) << seed;
  }
}

/// The workspace stops these, and damping by the reversed rates drove them 108 and 46 mm beyond it. Without
/// any torque the first one goes 39 mm by what it has, and the second stays within.
TEST(FaultyDevice, EncodersThatCountBackwardsAndWereNotNamedAreNotDrivenOnBySafeDamping) {
  const FaultCase fast = run_fault_case(702198);
  EXPECT_EQ(fast.found, control::bit(control::Fault::kWorkspace));
  EXPECT_LE(fast.way_beyond, 0.050);
  const FaultCase slow = run_fault_case(704298);
  EXPECT_EQ(slow.found, control::bit(control::Fault::kWorkspace));
  EXPECT_LE(slow.way_beyond, 0.005);
}

/// 177 mJ was the most in 500 such stops before the damping was watched.
TEST(FaultyDevice, EncodersThatCountBackwardsLetTheSafeStatePutInLittleEnergy) {
  for (std::uint64_t seed = 1000; seed < 1100; ++seed)
    EXPECT_LE(run_stop_case(seed, DeviceFault::kEncoderReversed).energy_put_in, 0.020) << seed;
}

TEST(HealthyDevice, IsDampedUntilItIsAtRestAfterAnyStop) {
  for (const Hardness& hardness :
       {Hardness{}, Hardness{.is_model_wrong = true}, Hardness{.is_rig_other = true}})
    for (std::uint64_t seed = 1; seed <= 40; ++seed)
      EXPECT_LE(run_stop_case(seed, std::nullopt, hardness).speed_when_dropped, 0.02) << seed;
}

TEST(HealthyDevice, OfWeakMotorsOtherFrictionAndOtherArmsIsNotCalledAWrongEncoder) {
  constexpr auto kWrong =
      control::bit(control::Fault::kEncoderReversed) | control::bit(control::Fault::kEncoderStill);
  for (std::uint64_t seed = 1; seed <= 40; ++seed)
    EXPECT_EQ(run_healthy_case(seed, {.is_rig_other = true}) & kWrong, 0U) << seed;
}

TEST(HealthyDevice, RaisesNoAlarm) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    EXPECT_EQ(control::fault_text(run_healthy_case(seed)), "") << seed;
}

}  // namespace
}  // namespace tonus::testing
