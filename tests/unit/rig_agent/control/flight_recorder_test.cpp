#include "rig_agent/control/flight_recorder.hpp"

#include <gtest/gtest.h>

namespace tonus::control {
namespace {

CycleRecord cycle(std::uint64_t number) {
  CycleRecord record;
  record.cycle = number;
  return record;
}

TEST(FlightRecorder, HoldsTheLastRecordsOldestFirstOnceFrozen) {
  FlightRecorder recorder(4);
  for (std::uint64_t i = 0; i < 10; ++i) recorder.put(cycle(i));
  recorder.freeze();
  ASSERT_EQ(recorder.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(recorder.at(i).cycle, 6 + i);
}

TEST(FlightRecorder, HoldsWhatThereIsWhenFrozenEarly) {
  FlightRecorder recorder(4);
  recorder.put(cycle(0));
  recorder.put(cycle(1));
  recorder.freeze();
  ASSERT_EQ(recorder.size(), 2U);
  EXPECT_EQ(recorder.at(0).cycle, 0U);
  EXPECT_EQ(recorder.at(1).cycle, 1U);
}

TEST(FlightRecorder, ChangesNothingWhileFrozenAndGoesOnOnceItHasBeenRead) {
  FlightRecorder recorder(2);
  recorder.put(cycle(0));
  recorder.put(cycle(1));
  recorder.freeze();
  recorder.put(cycle(2));
  recorder.release_if_read();
  EXPECT_EQ(recorder.at(1).cycle, 1U);
  recorder.set_read(recorder.number());
  EXPECT_TRUE(recorder.is_frozen());  // Until the loop releases it.
  recorder.release_if_read();
  EXPECT_EQ(recorder.size(), 0U);
  recorder.put(cycle(3));
  recorder.freeze();
  EXPECT_EQ(recorder.at(0).cycle, 1U);
  EXPECT_EQ(recorder.at(1).cycle, 3U);
}

TEST(FlightRecorder, NumbersWhatItFreezes) {
  FlightRecorder recorder(2);
  EXPECT_EQ(recorder.number(), 0U);
  recorder.freeze();
  recorder.freeze();
  EXPECT_EQ(recorder.number(), 1U);
  recorder.set_read(1);
  recorder.release_if_read();
  recorder.freeze();
  EXPECT_EQ(recorder.number(), 2U);
  recorder.release_if_read();  // The first was read, the second was not.
  EXPECT_TRUE(recorder.is_frozen());
}

}  // namespace
}  // namespace tonus::control
