#include "rig_agent/control/spsc_queue.hpp"

#include <cstdint>
#include <gtest/gtest.h>
#include <thread>

namespace tonus::control {
namespace {

TEST(SpscQueue, GivesBackInOrderWhatWasPushed) {
  SpscQueue<int> queue(4);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(queue.try_push(i));
  int item = -1;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(queue.try_pop(item));
    EXPECT_EQ(item, i);
  }
  EXPECT_FALSE(queue.try_pop(item));
}

TEST(SpscQueue, RefusesAndCountsWhatFindsItFull) {
  SpscQueue<int> queue(4);
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(queue.try_push(i));
  EXPECT_FALSE(queue.try_push(4));
  EXPECT_FALSE(queue.try_push(5));
  EXPECT_EQ(queue.dropped(), 2U);
  EXPECT_EQ(queue.size(), 4U);
  int item = -1;
  ASSERT_TRUE(queue.try_pop(item));
  EXPECT_EQ(item, 0);
  EXPECT_TRUE(queue.try_push(6));
}

TEST(SpscQueue, RoundsItsCapacityUpToAPowerOfTwo) {
  EXPECT_EQ(SpscQueue<int>(5).capacity(), 8U);
  EXPECT_EQ(SpscQueue<int>(0).capacity(), 2U);
}

TEST(SpscQueue, LosesAndTearsNothingBetweenTwoThreads) {
  // Both words of an item are equal unless a reader sees it half written.
  struct Item {
    std::uint64_t first = 0;
    std::uint64_t second = 0;
  };
  constexpr std::uint64_t kItems = 200'000;
  SpscQueue<Item> queue(64);
  std::thread producer([&] {
    for (std::uint64_t i = 1; i <= kItems;) {
      if (queue.try_push({i, i})) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  std::uint64_t expected = 1;
  bool is_whole = true;
  while (expected <= kItems && is_whole) {
    Item item;
    if (!queue.try_pop(item)) {
      std::this_thread::yield();
      continue;
    }
    is_whole = item.first == expected && item.second == expected;
    ++expected;
  }
  EXPECT_TRUE(is_whole) << "at item " << expected - 1;
  Item drain;
  while (expected <= kItems) expected += queue.try_pop(drain) ? 1 : 0;
  producer.join();
}

}  // namespace
}  // namespace tonus::control
