#include "services/recording/recording.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "services/recording/number_text.hpp"

namespace tonus::recording {
namespace {

std::string number_text(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

TEST(Recording, TakesAForceSignForConvertedOneAxisChannelsOnly) {
  Recording recording;
  recording.rig.kind = RigKind::kOneAxis;
  EXPECT_TRUE(state_force_sign(recording, -1));
  EXPECT_EQ(recording.rig.force_calibration(0, 0), -1.0);
  EXPECT_FALSE(state_force_sign(recording, 0));
  recording.rig.kind = RigKind::kCartesian;
  EXPECT_FALSE(state_force_sign(recording, -1));
  recording.rig.kind = RigKind::kOneAxis;
  recording.is_raw = true;
  EXPECT_FALSE(state_force_sign(recording, -1));
}

TEST(Recording, PlacesRowsByTheSamplingFrequency) {
  Recording recording;
  recording.sampling_frequency = 300.0;
  EXPECT_EQ(row_time_ns(recording, 0), 0);
  EXPECT_EQ(row_time_ns(recording, 2), 6'666'667);
  EXPECT_EQ(row_time_ns(recording, 300), 1'000'000'000);
}

TEST(Recording, WritesNumbersThatReadBackTheSame) {
  EXPECT_EQ(number_text(8000.0), "8000");
  EXPECT_EQ(number_text(1e15), "1000000000000000");
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(-0.0), "-0");
  EXPECT_EQ(number_text(1e300), "1e+300");
  EXPECT_EQ(number_text(std::numeric_limits<double>::denorm_min()), "5e-324");
}

}  // namespace
}  // namespace tonus::recording
