#include "services/dashboard/gateway/latest_values.hpp"

#include <gtest/gtest.h>

namespace tonus::dashboard {
namespace {

PassedMessage message(std::uint32_t channel, std::uint8_t key, std::uint64_t time, std::size_t bytes = 24) {
  bus::Key k{};
  k[0] = key;
  return {channel, k, time, std::make_shared<const bus::Payload>(bytes)};
}

TEST(LatestValues, HasTheNewestOfEachKeyInTheOrderOfComing) {
  LatestValues values({});
  values.put(message(1, 'a', 1));
  values.put(message(1, 'b', 2));
  values.put(message(1, 'a', 3));
  const auto all = values.of(1);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].time_ns, 2U);
  EXPECT_EQ(all[1].time_ns, 3U);
  EXPECT_TRUE(values.of(2).empty());
}

TEST(LatestValues, ForgetsWhatHasNotChangedForLongestAndCountsIt) {
  LatestValues values({.messages = 2});
  values.put(message(1, 'a', 1));
  values.put(message(1, 'b', 2));
  values.put(message(1, 'a', 3));
  values.put(message(1, 'c', 4));
  const auto all = values.of(1);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].time_ns, 3U);
  EXPECT_EQ(all[1].time_ns, 4U);
  EXPECT_EQ(values.forgotten(), 1U);
}

TEST(LatestValues, BytesOfATopicAreBoundedAndThoseOfAnotherOneUntouched) {
  LatestValues values({.messages = 1000, .bytes = 100});
  values.put(message(2, 'z', 0, 90));
  for (std::uint8_t key = 0; key < 50; ++key) values.put(message(1, key, key, 30));
  EXPECT_EQ(values.of(1).size(), 3U);
  EXPECT_EQ(values.of(2).size(), 1U);
  EXPECT_EQ(values.bytes(), 180U);
  EXPECT_EQ(values.messages(), 4U);
}

}  // namespace
}  // namespace tonus::dashboard
