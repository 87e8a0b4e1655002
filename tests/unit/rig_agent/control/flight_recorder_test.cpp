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

TEST(FlightRecorder, ChangesNothingWhileFrozenAndGoesOnAfterRelease) {
  FlightRecorder recorder(2);
  recorder.put(cycle(0));
  recorder.put(cycle(1));
  recorder.freeze();
  recorder.put(cycle(2));
  EXPECT_EQ(recorder.at(1).cycle, 1U);
  recorder.release();
  EXPECT_EQ(recorder.size(), 0U);
  recorder.put(cycle(3));
  recorder.freeze();
  EXPECT_EQ(recorder.at(0).cycle, 1U);
  EXPECT_EQ(recorder.at(1).cycle, 3U);
}

}  // namespace
}  // namespace tonus::control
