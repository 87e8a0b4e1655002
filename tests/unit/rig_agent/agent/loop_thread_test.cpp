#include "rig_agent/agent/loop_thread.hpp"

#include <chrono>
#include <gtest/gtest.h>

#include "tests/support/simulated_rig.hpp"

namespace tonus::rig {
namespace {

control::RealtimeRequest nothing() {
  control::RealtimeRequest request;
  request.fifo_priority.reset();
  request.lock_memory = false;
  return request;
}

/// Waits until the loop has made so many cycles; false after a minute.
bool wait_for_cycles(const control::RigLoop& loop, std::uint64_t cycles) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (loop.state().cycle < cycles) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::yield();
  }
  return true;
}

TEST(LoopThread, StepsTheLoopAtThePacersPeriods) {
  SimulatedRig rig;
  LoopThread thread(rig.loop(), true, nothing());
  ASSERT_NE(thread.pacer(), nullptr);
  const control::Pacer& pacer = *thread.pacer();
  ASSERT_TRUE(wait_for_cycles(rig.loop(), 50));
  thread.stop();
  EXPECT_EQ(rig.loop().state().cycle, pacer.cycles());
}

TEST(LoopThread, SaysWhatTheSystemRefused) {
  SimulatedRig rig;
  control::RealtimeRequest request = nothing();
  request.cpu = 1023;  // Nobody has so many.
  LoopThread thread(rig.loop(), true, request);
  EXPECT_EQ(thread.refusal(), "realtime: processor 1023 refused (Invalid argument)");
  EXPECT_EQ(thread.statement(), thread.refusal());
}

TEST(LoopThread, SaysNothingOfRefusalWhereNothingWasRefused) {
  SimulatedRig rig;
  LoopThread thread(rig.loop(), true, nothing());
  EXPECT_EQ(thread.refusal(), "");
}

TEST(LoopThread, IsNoThreadWhereTheLoopIsNotPaced) {
  SimulatedRig rig;
  LoopThread thread(rig.loop(), false, {});
  EXPECT_EQ(thread.pacer(), nullptr);
  EXPECT_EQ(thread.refusal(), "");
  EXPECT_EQ(thread.statement(), "simulated clock, as fast as it goes");
}

}  // namespace
}  // namespace tonus::rig
