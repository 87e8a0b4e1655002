#include "services/recording/auxiliary_files.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <limits>

#include "services/recording/dataset.hpp"
#include "tests/unit/services/recording/dataset_folder.hpp"

namespace tonus::recording {
namespace {

using ::testing::HasSubstr;

const std::string kStem = "sub-01/ses-02/motion/sub-01_ses-02_task-unloaded_";
const std::string kRest = "_acq-left_run-03_";

class AuxiliaryFiles : public testing::DatasetFolder {
 protected:
  /// The raw recording of three rows at 200 Hz, with two channels of two values a row.
  void put_with_channels() {
    put_raw();
    put_file("motion.json", R"({"TaskName": "unloaded", "SamplingFrequency": 400})");
    put_file("channels.tsv",
             "name\tcomponent\ttype\ttracked_point\tunits\n"
             "Biceps\tn/a\tMISC\tn/a\tmV\nGrip\tn/a\tMISC\tn/a\tN\n");
    put_file("channels.json", R"({"FirstValue_s": -0.0025, "Auxiliary": {"Biceps": {"Type": "EMG"}}})");
    put_file("motion.tsv", "1\t0.1\n2\t0.2\n3\tn/a\n4\t0.4\n5\t0.5\n6\t0.6\n");
  }
  void put_file(const std::string& suffix, const std::string& text,
                const std::string& system = "auxiliaryx2") {
    put(kStem + "tracksys-" + system + kRest + suffix, text);
  }
  [[nodiscard]] std::string refusal() const {
    const auto read = read_dataset(root_);
    return read ? std::string("accepted") : read.error().message;
  }
};

TEST_F(AuxiliaryFiles, AreReadBesideTheRecordingThatTheyBelongToAndAreNoRuns) {
  put_with_channels();
  const auto read = read_dataset(root_);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 1U);
  const auto& series = read->front().auxiliary;
  ASSERT_EQ(series.size(), 2U);
  EXPECT_EQ(series[0].channel, (AuxiliaryChannel{"Biceps", "EMG", "mV", 1.0, 400.0}));
  EXPECT_EQ(series[1].channel, (AuxiliaryChannel{"Grip", "MISC", "N", 1.0, 400.0}));
  EXPECT_EQ(series[0].values, (std::vector<float>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(series[1].values[1], 0.2F);
  EXPECT_TRUE(std::isnan(series[1].values[2]));
}

TEST_F(AuxiliaryFiles, AreWrittenSoThatEveryFloatAndTheOrderOfChannelsOfSeveralRatesComeBack) {
  put_raw();
  auto recordings = read_dataset(root_).value();
  const float tiny = std::numeric_limits<float>::denorm_min();
  const float largest = std::numeric_limits<float>::max();
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  recordings.front().auxiliary = {
      {{"Fast", "EMG", "mV", 1.0, 400.0}, 2, {0.1F, -0.0F, tiny, largest, nothing, 1e-7F}},
      {{"Slow", "TRIG", "n/a", 1.0, 200.0}, 1, {0.0F, 1.0F, nothing}},
      {{"Other", "MISC", "N", 1.0, 400.0}, 2, {1, 2, 3, 4, 5, 16777217.0F}}};
  ASSERT_TRUE(write_dataset(folder_ / "written", recordings));
  const auto read = read_dataset(folder_ / "written");
  ASSERT_TRUE(read) << read.error().message;
  const auto& after = read->front().auxiliary;
  ASSERT_EQ(after.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& before = recordings.front().auxiliary[i];
    EXPECT_EQ(after[i].channel, before.channel);
    ASSERT_EQ(after[i].values.size(), before.values.size());
    for (std::size_t k = 0; k < before.values.size(); ++k) {
      if (std::isnan(before.values[k])) {
        EXPECT_TRUE(std::isnan(after[i].values[k]));
      } else {
        EXPECT_EQ(std::signbit(after[i].values[k]), std::signbit(before.values[k]));
        EXPECT_EQ(after[i].values[k], before.values[k]);
      }
    }
  }
}

TEST_F(AuxiliaryFiles, SayInEachFileWhatTheChannelsAreAndWhenTheFirstValueIs) {
  put_with_channels();
  const auto recordings = read_dataset(root_).value();
  ASSERT_TRUE(write_dataset(folder_ / "written", recordings));
  const auto stem = (folder_ / "written" / (kStem + "tracksys-auxiliaryx2" + kRest)).string();
  EXPECT_EQ(content(stem + "channels.tsv"),
            "name\tcomponent\ttype\ttracked_point\tunits\tdescription\n"
            "Biceps\tn/a\tMISC\tn/a\tmV\tEMG\nGrip\tn/a\tMISC\tn/a\tN\tMISC\n");
  EXPECT_THAT(content(stem + "channels.json"), HasSubstr("\"FirstValue_s\": -0.0025"));
  EXPECT_THAT(content(stem + "motion.json"), HasSubstr("\"SamplingFrequency\": 400"));
  EXPECT_EQ(content(stem + "motion.tsv"), "1\t0.1\n2\t0.2\n3\tn/a\n4\t0.4\n5\t0.5\n6\t0.6\n");
}

TEST_F(AuxiliaryFiles, ThatDoNotFitTheirRecordingAreRefusedByFileAndReason) {
  put_with_channels();
  put_file("motion.tsv", "1\t0.1\n2\t0.2\n");
  EXPECT_THAT(refusal(), HasSubstr("_motion.tsv: 2 rows are not allowed; expected 6, 2 for each"));
  put_with_channels();
  put_file("motion.tsv", "1\t0.1\n2\n");
  EXPECT_THAT(refusal(), HasSubstr("_motion.tsv:2: this number of cells is not allowed; expected 2"));
  put_with_channels();
  put_file("motion.tsv", "1\t0.1\nx\t0.2\n");
  EXPECT_THAT(refusal(), HasSubstr("column '1': 'x' is not allowed: a number or n/a"));
  put_with_channels();
  put_file("motion.json", R"({"SamplingFrequency": 500})");
  EXPECT_THAT(refusal(), HasSubstr("SamplingFrequency: 500 is not allowed: 400 Hz"));
  put_with_channels();
  put_file("channels.json", R"({"Auxiliary": {"Biceps": {"Type": "MUSCLE"}}})");
  EXPECT_THAT(refusal(), HasSubstr("MUSCLE"));
  put_with_channels();
  put_file("channels.tsv", "name\tunits\nGrip\tmV\nGrip\tN\n");
  EXPECT_THAT(refusal(), HasSubstr("Grip"));
}

TEST_F(AuxiliaryFiles, WithoutTheirRecordingAreNotLostWithoutAWord) {
  put_with_channels();
  put(kStem + "tracksys-auxiliaryx2_acq-left_run-04_motion.tsv", "1\n");
  EXPECT_THAT(refusal(), HasSubstr("run-04_motion.tsv: has channels of a recording that is not there"));
  const auto usable = read_usable(root_);
  ASSERT_TRUE(usable) << usable.error().message;
  EXPECT_EQ(usable->recordings.front().auxiliary.size(), 2U);
  ASSERT_EQ(usable->left_out.size(), 1U);
  EXPECT_THAT(usable->left_out.front(), HasSubstr("run-04"));
}

TEST_F(AuxiliaryFiles, OfAnotherNumberOfValuesThanRowsAreNotWritten) {
  put_with_channels();
  auto recordings = read_dataset(root_).value();
  recordings.front().auxiliary[1].values.pop_back();
  const auto written = write_dataset(folder_ / "written", recordings);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, HasSubstr("channel Grip: 5 values are not allowed; expected 6"));
}

}  // namespace
}  // namespace tonus::recording
