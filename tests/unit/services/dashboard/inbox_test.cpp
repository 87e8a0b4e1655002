#include "services/dashboard/gateway/inbox.hpp"

#include <gtest/gtest.h>

namespace tonus::dashboard {
namespace {

PassedMessage of_bytes(std::size_t bytes) { return {1, {}, 0, std::make_shared<const bus::Payload>(bytes)}; }

TEST(Inbox, WakesOnceForAllThatComesBeforeItIsTaken) {
  int wakes = 0;
  Inbox inbox([&wakes] { ++wakes; });
  inbox.put(of_bytes(10), true);
  inbox.put(of_bytes(10), false);
  inbox.put(OperatorReply{});
  EXPECT_EQ(wakes, 1);
  const auto contents = inbox.take();
  EXPECT_EQ(contents.messages.size(), 2U);
  EXPECT_EQ(contents.replies.size(), 1U);
  inbox.put(of_bytes(10), true);
  EXPECT_EQ(wakes, 2);
}

TEST(Inbox, LeavesOutLiveMessagesWhenFullAndStillTakesState) {
  Inbox inbox([] {}, 100);
  for (int i = 0; i < 20; ++i) inbox.put(of_bytes(50), true);
  const auto dropped = inbox.live_dropped();
  EXPECT_EQ(dropped, 17U);  // 3 x 50 bytes are the first to pass 100
  inbox.put(of_bytes(50), false);
  EXPECT_EQ(inbox.state_dropped(), 0U);
  EXPECT_EQ(inbox.take().messages.size(), 4U);
}

TEST(Inbox, IsBoundedForStateToo) {
  Inbox inbox([] {}, 100);
  for (int i = 0; i < 100; ++i) inbox.put(of_bytes(50), false);
  EXPECT_EQ(inbox.take().messages.size(), 21U);  // ten times the limit, and the one that passes it
  EXPECT_EQ(inbox.state_dropped(), 79U);
}

}  // namespace
}  // namespace tonus::dashboard
