// A second pair of eyes: whatever becomes of the rig agent, the torque goes.
#include <csignal>
#include <gtest/gtest.h>

#include "tests/fault/watchdog/watched_agent.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{60};

TEST(Watchdog, DropsTheTorqueOfAnAgentThatIsKilled) {
  WatchedAgent agent;
  ASSERT_EQ(kill(agent.process().id(), SIGKILL), 0);
  EXPECT_GE(agent.time_to_off(monotonic_ns(), kLimit), -1'000'000'000) << agent.printed();
  EXPECT_EQ(agent.amplifier().is_enabled, 0);
  EXPECT_EQ(agent.amplifier().torque[0], 0.0);
}

TEST(Watchdog, DropsTheTorqueOfAnAgentThatIsStoppedAndKeepsItDownWhenItGoesOn) {
  WatchedAgent agent;
  ASSERT_EQ(kill(agent.process().id(), SIGSTOP), 0);
  EXPECT_GE(agent.time_to_off(monotonic_ns(), kLimit), 0) << agent.printed();
  ASSERT_EQ(kill(agent.process().id(), SIGCONT), 0);
  EXPECT_TRUE(agent.process().wait_for_output("the rig is held: fault: ", kLimit)) << agent.printed();
  EXPECT_EQ(agent.amplifier().is_enabled, 0);
}

TEST(Watchdog, DropsTheTorqueOfALoopWhoseDriverHangsAndTheAgentCanStillBeEnded) {
  WatchedAgent agent("hang_after=500");
  EXPECT_GE(agent.time_to_off(0, kLimit), 0) << agent.printed();
  EXPECT_TRUE(agent.process().wait_for_output("the loop stands still", kLimit)) << agent.printed();
  agent.process().signal(SIGTERM);
  EXPECT_EQ(agent.process().wait(kLimit), 1) << agent.printed();
  EXPECT_NE(agent.printed().find("the torque is off"), std::string::npos) << agent.printed();
}

TEST(Watchdog, LeavesAnAgentAloneThatEndsInOrder) {
  WatchedAgent agent;
  agent.process().signal(SIGTERM);
  EXPECT_EQ(agent.process().wait(kLimit), 0) << agent.printed();
  EXPECT_EQ(agent.amplifier().disabled_ns, 0);
  EXPECT_EQ(agent.amplifier().is_enabled, 0);
}

TEST(Watchdog, ARigWhoseAgentWasKilledIsHeldAtTheNextStart) {
  WatchedAgent agent;
  ASSERT_EQ(kill(agent.process().id(), SIGKILL), 0);
  (void)agent.process().wait(kLimit);
  agent.restart();
  EXPECT_TRUE(agent.process().wait_for_output("ended while the rig was under power", kLimit))
      << agent.printed();
}

}  // namespace
}  // namespace tonus::testing
