#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>

#include "services/recording/dataset.hpp"
#include "tests/unit/services/recording/dataset_folder.hpp"

/// The measured data that TONUS_DATA_DIR names: five 60 s records of a human ankle at 1000 Hz.
namespace tonus::recording {
namespace {

class MeasuredAnkle : public testing::DatasetFolder {
 protected:
  void SetUp() override {
    DatasetFolder::SetUp();
    const char* data = std::getenv("TONUS_DATA_DIR");
    if (data == nullptr) GTEST_SKIP() << "TONUS_DATA_DIR is not set: no measured data to read";
    dataset_ = std::filesystem::path(data) / "ankle";
    if (!std::filesystem::exists(dataset_))
      GTEST_SKIP() << dataset_ << " is not there: no measured data to read";
  }

  std::filesystem::path dataset_;
};

TEST_F(MeasuredAnkle, IsReadAsFiveOneAxisRecords) {
  const auto recordings = read_dataset(dataset_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  ASSERT_EQ(recordings->size(), 5U);
  // First and third rows of run 2 as `head -3` prints them.
  const Recording& run2 = (*recordings)[1];
  EXPECT_EQ(run2.run, 2);
  EXPECT_EQ(run2.rows[0].raw.encoder_count[0], 0.13292405);
  EXPECT_EQ(run2.rows[2].raw.force_V[0], -7.3147712);
  for (std::size_t i = 0; i < recordings->size(); ++i) {
    const Recording& recording = (*recordings)[i];
    EXPECT_EQ(recording.rows.size(), 60000U);
    EXPECT_EQ(recording.rig.kind, RigKind::kOneAxis);
    EXPECT_EQ(recording.displacement_unit, "rad");
    EXPECT_EQ(recording.force_unit, "N m");
    EXPECT_FALSE(recording.is_force_sign_stated);
    ASSERT_EQ(recording.events.size(), 1U);
    EXPECT_TRUE(recording.events[0].is_continuous());
    EXPECT_EQ(recording.events[0].duration_s, 60.0);
    EXPECT_EQ(recording.events[0].trial, static_cast<std::int64_t>(i) + 1);
  }
}

TEST_F(MeasuredAnkle, IsWrittenAndReadBackTheSame) {
  auto recordings = read_dataset(dataset_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  for (Recording& recording : *recordings) ASSERT_TRUE(state_force_sign(recording, -1));
  const auto written = write_dataset(root_, *recordings);
  ASSERT_TRUE(written) << written.error().message;
  const auto again = read_dataset(root_);
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_EQ(again->size(), recordings->size());
  for (std::size_t run = 0; run < again->size(); ++run) {
    const Recording& before = (*recordings)[run];
    const Recording& after = (*again)[run];
    EXPECT_TRUE(after.is_force_sign_stated);
    EXPECT_EQ(after.rig.force_calibration(0, 0), -1.0);
    ASSERT_EQ(after.rows.size(), before.rows.size());
    std::size_t different = 0;
    for (std::size_t i = 0; i < after.rows.size(); ++i) {
      different += after.rows[i].raw.encoder_count != before.rows[i].raw.encoder_count;
      different += after.rows[i].raw.force_V != before.rows[i].raw.force_V;
    }
    EXPECT_EQ(different, 0U);
  }
}

}  // namespace
}  // namespace tonus::recording
