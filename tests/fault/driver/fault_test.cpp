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

TEST(HealthyDevice, RaisesNoAlarm) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    EXPECT_EQ(control::fault_text(run_healthy_case(seed)), "") << seed;
}

}  // namespace
}  // namespace tonus::testing
