#include "rig_agent/watchdog/watch.hpp"

#include <gtest/gtest.h>

namespace tonus::watchdog {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// A watch over a made-up agent: `at_look` is told how often the watchdog has looked, before it rests.
class WatchTest : public ::testing::Test {
 protected:
  WatchEnd run(const std::function<void(int look)>& at_look) {
    return watch(pulse_, {.limit = milliseconds(20),
                          .disable =
                              [this] {
                                ++disabled_;
                                return is_confirmed_;
                              },
                          .is_agent_there = [this] { return is_agent_there_; },
                          .rest =
                              [&](nanoseconds duration) {
                                now_ += duration;
                                at_look(++looks_);
                              },
                          .now = [this] { return now_; }});
  }
  void end_in_order() { pulse_.is_ending = 1; }

  control::Pulse pulse_{};
  bool is_agent_there_ = true;
  bool is_confirmed_ = true;
  int disabled_ = 0;
  int looks_ = 0;
  nanoseconds now_{};
};

TEST_F(WatchTest, LeavesALoopAloneWhoseCyclesCome) {
  pulse_.is_powered = 1;
  EXPECT_EQ(run([&](int look) {
              if (look % 4 == 0) pulse_.cycles += 1;
              if (look == 1000) end_in_order();
            }),
            WatchEnd::kInOrder);
  EXPECT_EQ(disabled_, 0);
}

TEST_F(WatchTest, DropsTheTorqueOfALoopThatStandsStillWithinTheLimitAndALook) {
  pulse_.is_powered = 1;
  nanoseconds tripped{};
  (void)run([&](int look) {
    if (look < 10) pulse_.cycles += 1;
    if (tripped == nanoseconds{} && pulse_.has_tripped != 0) tripped = now_;
    if (look == 50) is_agent_there_ = false;
  });
  const auto last_cycle = milliseconds(9 * 4);
  EXPECT_GT(tripped, last_cycle + milliseconds(20));
  EXPECT_LE(tripped, last_cycle + milliseconds(20 + 2 * 4));
}

TEST_F(WatchTest, KeepsTheTorqueDownWhenTheLoopWakesUpAgain) {
  pulse_.is_powered = 1;
  (void)run([&](int look) {
    if (look < 5 || look > 20) pulse_.cycles += 1;
    if (look == 100) is_agent_there_ = false;
  });
  EXPECT_GT(disabled_, 80);
  EXPECT_EQ(pulse_.has_tripped, 1U);
}

TEST_F(WatchTest, DropsTheTorqueOfAnAgentThatIsGoneAtOnceAndUntilTheDeviceConfirms) {
  pulse_.is_powered = 1;
  is_confirmed_ = false;
  EXPECT_EQ(run([&](int look) {
              pulse_.cycles += 1;
              if (look == 10) is_agent_there_ = false;
              if (look == 30) is_confirmed_ = true;
            }),
            WatchEnd::kAgentIsGone);
  EXPECT_EQ(looks_, 30);
  EXPECT_EQ(disabled_, 21);
}

TEST_F(WatchTest, DoesNothingWithoutPower) {
  EXPECT_EQ(run([&](int look) {
              if (look == 1000) end_in_order();
            }),
            WatchEnd::kInOrder);
  EXPECT_EQ(disabled_, 0);
}

}  // namespace
}  // namespace tonus::watchdog
