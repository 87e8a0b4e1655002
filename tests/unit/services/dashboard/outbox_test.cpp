#include "services/dashboard/gateway/outbox.hpp"

#include <gtest/gtest.h>

namespace tonus::dashboard {
namespace {

using std::chrono::milliseconds;

Outgoing message(const std::string& head) { return {head, nullptr, false}; }

Clock::TimePoint at(milliseconds time) { return Clock::TimePoint(std::chrono::seconds(100) + time); }

TEST(Outbox, StateKeepsItsOrderAndGoesBeforeLiveMessages) {
  Outbox outbox({});
  outbox.push_live(1, message("live"), at(milliseconds(0)));
  ASSERT_TRUE(outbox.push_state(message("a")));
  ASSERT_TRUE(outbox.push_state(message("b")));
  EXPECT_EQ(outbox.pop()->head, "a");
  EXPECT_EQ(outbox.pop()->head, "b");
  EXPECT_EQ(outbox.pop()->head, "live");
  EXPECT_FALSE(outbox.pop());
  EXPECT_EQ(outbox.sent(), 3U);
}

TEST(Outbox, RefusesStateThatFindsItFullAndLosesNothingOfWhatIsThere) {
  Outbox outbox({.state_messages = 2});
  EXPECT_TRUE(outbox.push_state(message("a")));
  EXPECT_TRUE(outbox.push_state(message("b")));
  EXPECT_FALSE(outbox.push_state(message("c")));
  EXPECT_EQ(outbox.pop()->head, "a");
  EXPECT_EQ(outbox.pop()->head, "b");
}

TEST(Outbox, RefusesStateBeyondItsBytes) {
  Outbox outbox({.state_bytes = 10});
  EXPECT_TRUE(outbox.push_state(message("123456")));
  EXPECT_FALSE(outbox.push_state(message("12345")));
  EXPECT_TRUE(outbox.push_state(message("1234")));
}

TEST(Outbox, OldestLiveMessagesGiveWayAndAreCounted) {
  Outbox outbox({.live_messages = 2, .live_rate = 1000.0});
  for (const char* name : {"a", "b", "c", "d"}) outbox.push_live(1, message(name), at(milliseconds(0)));
  EXPECT_EQ(outbox.thinned(), 2U);
  EXPECT_EQ(outbox.pop()->head, "c");
  EXPECT_EQ(outbox.pop()->head, "d");
}

TEST(Outbox, LiveMessagesAreBoundedInBytes) {
  Outbox outbox({.live_bytes = 8, .live_rate = 1000.0});
  for (int i = 0; i < 5; ++i) outbox.push_live(1, message("1234"), at(milliseconds(0)));
  EXPECT_LE(outbox.waiting_bytes(), 8U);
  EXPECT_EQ(outbox.thinned(), 3U);
}

TEST(Outbox, LiveMessagesPassUpToTheirRate) {
  Outbox outbox({.live_messages = 100000, .live_rate = 100.0});
  // 10 s of 1000 messages/s, of which 100/s and one burst of a quarter of a second may pass.
  for (int i = 0; i < 10000; ++i) outbox.push_live(1, message("x"), at(milliseconds(i)));
  const auto passed = 10000 - static_cast<int>(outbox.thinned());
  EXPECT_GE(passed, 999);
  EXPECT_LE(passed, 1025 + 1);
}

TEST(Outbox, RateOfOneSubscriptionLeavesAnotherAlone) {
  Outbox outbox({.live_rate = 100.0});
  for (int i = 0; i < 1000; ++i) outbox.push_live(1, message("x"), at(milliseconds(0)));
  const auto before = outbox.thinned();
  outbox.push_live(2, message("y"), at(milliseconds(0)));
  EXPECT_EQ(outbox.thinned(), before);
}

TEST(Outbox, NothingIsThinnedBelowTheRate) {
  Outbox outbox({.live_rate = 250.0});
  for (int i = 0; i < 1000; ++i) {
    outbox.push_live(1, message("x"), at(milliseconds(10 * i)));
    EXPECT_TRUE(outbox.pop());
  }
  EXPECT_EQ(outbox.thinned(), 0U);
}

}  // namespace
}  // namespace tonus::dashboard
