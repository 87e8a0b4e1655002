#include "rig_agent/agent/emergency_signal.hpp"

#include <csignal>
#include <gtest/gtest.h>

#include "tests/support/simulated_rig.hpp"

namespace tonus::rig {
namespace {

TEST(EmergencySignal, StopsARingingHandleWithinTwoCycles) {
  SimulatedRig rig;
  const EmergencySignal signal(rig.loop());
  rig.start(rig.program());
  ASSERT_TRUE(rig.step_until_phase(control::Phase::kPerturbing));
  for (int i = 0; i < 90; ++i) rig.step();
  ASSERT_EQ(std::raise(SIGUSR1), 0);
  int cycles = 0;
  while (rig.loop().state().phase != control::Phase::kSafe && cycles < 10) {
    rig.step();
    ++cycles;
  }
  EXPECT_LE(cycles, 2);
  EXPECT_EQ(rig.loop().state().faults, control::bit(control::Fault::kEmergencyStop));
}

TEST(EmergencySignal, GivesTheSignalItsDefaultActionBackAtTheEnd) {
  SimulatedRig rig;
  { const EmergencySignal signal(rig.loop()); }
  EXPECT_EXIT(
      {
        std::raise(SIGUSR1);
        std::exit(0);
      },
      ::testing::KilledBySignal(SIGUSR1), "");
}

}  // namespace
}  // namespace tonus::rig
