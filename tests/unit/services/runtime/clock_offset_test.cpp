#include "services/runtime/clock_offset.hpp"

#include <gtest/gtest.h>
#include <random>

namespace tonus::runtime {
namespace {

TEST(ClockOffset, IsUnknownBeforeTheFirstRoundTrip) { EXPECT_FALSE(ClockOffset().at(0)); }

TEST(ClockOffset, IsExactWhereBothWaysAreEquallyLong) {
  ClockOffset offset;
  // 300 ns each way, 50 ns to answer; the other clock is 1000 ns ahead.
  ASSERT_TRUE(offset.add({0, 1300, 1350, 650}));
  const auto difference = offset.at(650);
  ASSERT_TRUE(difference);
  EXPECT_EQ(difference->offset, 1000);
  EXPECT_EQ(difference->uncertainty, 300);
  EXPECT_EQ(difference->round_trips, 1U);
}

TEST(ClockOffset, TakesTheShortestRoundTrip) {
  ClockOffset offset;
  offset.add({0, 51'000, 51'000, 100'000});          // long on the way back: wrong by 25 us
  offset.add({200'000, 211'000, 211'000, 220'000});  // 10 us each way
  offset.add({300'000, 391'000, 391'000, 400'000});  // long on the way there
  const auto difference = offset.at(400'000);
  ASSERT_TRUE(difference);
  EXPECT_EQ(difference->offset, 1000);
  EXPECT_GE(difference->uncertainty, 10'000);
  EXPECT_LE(difference->uncertainty, 10'010);
  EXPECT_EQ(difference->round_trips, 3U);
}

TEST(ClockOffset, HoldsTheTruthWhateverTheWaysTake) {
  std::mt19937_64 generator(4);
  std::exponential_distribution<double> way(1.0 / 50'000.0);
  for (int round = 0; round < 200; ++round) {
    const auto truth = static_cast<std::int64_t>(generator() % 2'000'000'000'000) - 1'000'000'000'000;
    ClockOffset offset;
    std::int64_t now = 1'000'000;
    for (int i = 0; i < 16; ++i) {
      const auto there = static_cast<std::int64_t>(way(generator));
      const auto back = static_cast<std::int64_t>(way(generator));
      const std::int64_t received = now + there + truth;
      const std::int64_t returned = now + there + 700 + back;
      ASSERT_TRUE(offset.add({now, received, received + 700, returned}));
      now = returned + 1000;
    }
    const auto difference = offset.at(now);
    EXPECT_LE(std::abs(difference->offset - truth), difference->uncertainty);
  }
}

TEST(ClockOffset, TrustsAnOldRoundTripLess) {
  ClockOffset offset;
  offset.add({0, 100, 100, 200});
  EXPECT_EQ(offset.at(200)->uncertainty, 100);
  // 50 parts in a million of 10 s.
  EXPECT_EQ(offset.at(10'000'000'200)->uncertainty, 100 + 500'000);
  // A newer one is better although its way was longer.
  offset.add({10'000'000'200, 10'000'040'200, 10'000'040'200, 10'000'080'200});
  EXPECT_EQ(offset.at(10'000'080'200)->uncertainty, 40'000);
}

TEST(ClockOffset, LeavesOutWhatCannotBe) {
  ClockOffset offset;
  EXPECT_FALSE(offset.add({1000, 0, 0, 900}));    // back before it was asked
  EXPECT_FALSE(offset.add({0, 500, 400, 1000}));  // answered before it was received
  EXPECT_FALSE(offset.at(1000));
}

TEST(ClockOffset, OfClocksFarApartDoesNotOverflow) {
  ClockOffset offset;
  const std::int64_t ahead = 9'000'000'000'000'000'000;
  offset.add({0, ahead, ahead, 10});
  EXPECT_EQ(offset.at(10)->offset, ahead - 5);
}

}  // namespace
}  // namespace tonus::runtime
