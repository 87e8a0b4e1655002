#include "rig_agent/drivers/replay.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>

namespace tonus::drivers {
namespace {

Recording recording_of(std::size_t rows) {
  Recording recording;
  recording.rate = 200.0;
  for (std::size_t i = 0; i < rows; ++i) {
    RecordedRow row;
    row.raw.acquisition_ns = 1'000'000'000 + static_cast<std::int64_t>(i) * 5'000'000;
    row.raw.encoder_count = {static_cast<double>(i), -static_cast<double>(i)};
    row.command = {0.001 * static_cast<double>(i), 0.0};
    recording.rows.push_back(row);
  }
  recording.segments = {{0, 2, 4}, {6, 7, 9}};
  return recording;
}

std::string refusal(Recording recording, double period = 0.005) {
  Replay driver(std::move(recording));
  const auto result = driver.configure(period);
  return result ? "accepted" : result.error().message;
}

class Playing : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(driver_.configure(0.005));
    ASSERT_TRUE(driver_.activate());
  }
  void play(std::uint32_t segment) {
    TrialNotice notice;
    notice.segment = segment;
    driver_.begin_trial(notice);
  }

  Replay driver_{recording_of(10)};
  Reading reading_;
};

TEST_F(Playing, HasNoDataBeforeATrialAndAfterItsLastRow) {
  EXPECT_EQ(driver_.read(reading_), DriverStatus::kNoData);
  play(0);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(driver_.read(reading_), DriverStatus::kOk);
  EXPECT_EQ(driver_.read(reading_), DriverStatus::kNoData);
}

TEST_F(Playing, GivesTheRowsAsRecordedAndMarksOnsetAndEnd) {
  play(1);
  for (int i = 6; i <= 9; ++i) {
    ASSERT_EQ(driver_.read(reading_), DriverStatus::kOk);
    EXPECT_EQ(reading_.raw.encoder_count[0], i);
    EXPECT_EQ(reading_.raw.encoder_count[1], -i);
    EXPECT_NEAR(reading_.recorded_command[0], 0.001 * i, 1e-15);
    EXPECT_EQ(reading_.mark, i == 7 ? RowMark::kOnset : i == 9 ? RowMark::kLast : RowMark::kNone);
  }
}

TEST_F(Playing, StampsOneSegmentAfterTheOtherAtTheRecordingsDistances) {
  std::int64_t before = 0;
  for (const std::uint32_t segment : {1U, 0U, 1U}) {  // In any order, and again.
    play(segment);
    while (driver_.read(reading_) == DriverStatus::kOk) {
      EXPECT_EQ(reading_.raw.acquisition_ns, before + 5'000'000);
      before = reading_.raw.acquisition_ns;
    }
  }
  EXPECT_EQ(before, 13 * 5'000'000);
}

TEST_F(Playing, PlaysNothingForASegmentThatThereIsNot) {
  play(2);
  EXPECT_EQ(driver_.read(reading_), DriverStatus::kNoData);
}

TEST(Replay, GivesMissingValuesAsTheyAre) {
  Recording recording = recording_of(10);
  recording.rows[1].raw.force_V[0] = std::numeric_limits<double>::quiet_NaN();
  Replay driver(recording);
  ASSERT_TRUE(driver.configure(0.005));
  ASSERT_TRUE(driver.activate());
  driver.begin_trial({});
  Reading reading;
  ASSERT_EQ(driver.read(reading), DriverStatus::kOk);
  ASSERT_EQ(driver.read(reading), DriverStatus::kOk);
  EXPECT_TRUE(std::isnan(reading.raw.force_V[0]));
}

TEST(Replay, RefusesWhatCannotBePlayedWithOneLine) {
  Recording empty = recording_of(10);
  empty.rows.clear();
  EXPECT_EQ(refusal(empty), "recording: rows: 0 is not allowed; expected 1 or more");

  Recording unsegmented = recording_of(10);
  unsegmented.segments.clear();
  EXPECT_EQ(refusal(unsegmented), "recording: segments: 0 is not allowed; expected 1 or more");

  Recording beyond = recording_of(10);
  beyond.segments[1].last = 10;
  EXPECT_EQ(refusal(beyond),
            "recording: segment 1: rows 6, 7, 10 (first, onset, last) are not allowed; expected first <= "
            "onset < last < 10");

  Recording backwards = recording_of(10);
  backwards.rows[3].raw.acquisition_ns = backwards.rows[2].raw.acquisition_ns;
  EXPECT_EQ(refusal(backwards),
            "recording: acquisition_ns of row 3: 1010000000 is not allowed; expected more than 1010000000 of "
            "the row before");

  EXPECT_EQ(refusal(recording_of(10), 0.001),
            "recording: the loop's period: 0.001 s is not allowed; expected the recording's 0.005 s");

  Recording unscaled = recording_of(10);
  unscaled.geometry.counts_per_unit[0] = 0.0;
  EXPECT_NE(refusal(unscaled), "accepted");
}

}  // namespace
}  // namespace tonus::drivers
