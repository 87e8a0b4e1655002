#include <algorithm>
#include <cctype>
#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <random>
#include <set>

#include "services/core/text_file.hpp"
#include "services/recording/dataset.hpp"
#include "services/recording/file_name.hpp"
#include "tests/unit/services/recording/dataset_folder.hpp"

namespace tonus::recording {
namespace {

namespace fs = std::filesystem;

class DatasetWriter : public testing::DatasetFolder {
 protected:
  /// Made-up rows whose numbers need all their digits.
  static void fill_rows(Recording& recording, std::size_t count, bool has_two_axes) {
    std::mt19937_64 generator(7);
    std::normal_distribution<double> noise(0.0, 1.0 / 3.0);
    for (std::size_t i = 0; i < count; ++i) {
      Row row;
      row.raw.acquisition_ns = row_time_ns(recording, i);
      row.raw.encoder_count = {recording.is_raw ? std::round(1e6 * noise(generator)) : noise(generator),
                               has_two_axes ? 1e-9 * noise(generator) : 0.0};
      row.raw.force_V = {noise(generator), has_two_axes ? noise(generator) : 0.0};
      recording.rows.push_back(row);
    }
  }

  static Recording raw_recording() {
    Recording recording;
    recording.participant = {"sub-01", 0.31, 0.34, {}, 0.27, "right", 34.5, "F"};
    recording.session = "ses-01";
    recording.task = "unloaded";
    recording.task_description = "hold still";
    recording.acquisition = "farleft";
    recording.run = 12;
    recording.sampling_frequency = 200;
    recording.is_raw = true;
    recording.rig.encoder_zero = {17, -4};
    recording.rig.encoder_sign = {1, -1};
    recording.rig.force_calibration << 4.45, 0.01, -0.02, 4.4;
    recording.rig.force_offset_V = {0.1, -1.0 / 3.0};
    recording.rig.force_sensor_angle = 0.7;
    recording.rig.handle_mass = 0.15;
    recording.rig.force_saturation_V = 5;
    recording.shoulder = {{0.05, -0.1}, 0.3};
    recording.posture = "far left";
    recording.posture_position = Eigen::Vector2d(-0.295, 0.38);
    fill_rows(recording, 400, true);
    recording.rows[7] = {{row_time_ns(recording, 7), {}, {}}, true};
    recording.commanded.assign(400, {0.005, 1.0 / 7.0});
    recording.commanded[7] = kNoCommand;
    recording.phases.assign(400, 2);
    recording.phases[7] = 0;  // nothing is known of a missing row
    recording.events = {{0.1, 0.5, 1, 1, 45.0, 0.005, 0.2, {0.7, -0.1}, true, ""},
                        {0.9,
                         1.1,
                         2,
                         1,
                         90.0,
                         {},
                         {},
                         {0, 0},
                         false,
                         "early reaction: 0.3 N",
                         "resist",
                         1.0 / 3.0,
                         0.1,
                         0.5,
                         1.5}};
    return recording;
  }

  static Recording ankle_recording() {
    Recording recording;
    recording.participant.id = "sub-02";
    recording.task = "ankle";
    recording.tracking_system = "perturbator";
    recording.sampling_frequency = 1000;
    recording.rig.kind = RigKind::kOneAxis;
    recording.rig.counts_per_unit = {1, 1};
    recording.rig.force_saturation_V = std::numeric_limits<double>::infinity();
    recording.rig.force_calibration.setIdentity();
    recording.displacement_unit = "rad";
    recording.force_unit = "N m";
    recording.channel_names = {"ankle_angle", "ankle_torque"};
    recording.tracked_point = "ankle";
    EXPECT_TRUE(state_force_sign(recording, -1));
    fill_rows(recording, 50, false);
    recording.events = {{0.0, 0.05, 1, 1, {}, {}, {}, {0, 0}, true, ""}};
    return recording;
  }

  static void expect_same(const Recording& a, const Recording& b) {
    EXPECT_EQ(a.participant, b.participant);
    EXPECT_EQ(a.session, b.session);
    EXPECT_EQ(a.task, b.task);
    EXPECT_EQ(a.task_description, b.task_description);
    EXPECT_EQ(a.tracking_system, b.tracking_system);
    EXPECT_EQ(a.acquisition, b.acquisition);
    EXPECT_EQ(a.run, b.run);
    EXPECT_EQ(a.sampling_frequency, b.sampling_frequency);
    EXPECT_EQ(a.is_raw, b.is_raw);
    EXPECT_EQ(a.posture, b.posture);
    EXPECT_EQ(a.posture_position, b.posture_position);
    EXPECT_EQ(a.displacement_unit, b.displacement_unit);
    EXPECT_EQ(a.force_unit, b.force_unit);
    EXPECT_EQ(a.channel_names, b.channel_names);
    EXPECT_EQ(a.is_force_sign_stated, b.is_force_sign_stated);
    EXPECT_EQ(a.rig.kind, b.rig.kind);
    EXPECT_EQ(a.rig.links.l1, b.rig.links.l1);
    EXPECT_EQ(a.rig.links.l2, b.rig.links.l2);
    EXPECT_EQ(a.rig.encoder_zero, b.rig.encoder_zero);
    EXPECT_EQ(a.rig.encoder_sign, b.rig.encoder_sign);
    EXPECT_EQ(a.rig.counts_per_unit, b.rig.counts_per_unit);
    EXPECT_EQ(a.rig.force_calibration, b.rig.force_calibration);
    EXPECT_EQ(a.rig.force_offset_V, b.rig.force_offset_V);
    EXPECT_EQ(a.rig.force_sensor_angle, b.rig.force_sensor_angle);
    EXPECT_EQ(a.rig.handle_mass, b.rig.handle_mass);
    EXPECT_EQ(a.rig.force_saturation_V, b.rig.force_saturation_V);
    EXPECT_EQ(a.shoulder.origin, b.shoulder.origin);
    EXPECT_EQ(a.shoulder.angle, b.shoulder.angle);
    ASSERT_EQ(a.commanded.size(), b.commanded.size());
    for (std::size_t i = 0; i < a.commanded.size(); ++i) {
      if (std::isfinite(a.commanded[i][0])) {
        EXPECT_EQ(a.commanded[i], b.commanded[i]) << i;
      }
      EXPECT_EQ(std::isfinite(a.commanded[i][0]), std::isfinite(b.commanded[i][0])) << i;
    }
    EXPECT_EQ(a.phases, b.phases);
    EXPECT_EQ(a.events, b.events);
    EXPECT_EQ(a.contractions, b.contractions);
    ASSERT_EQ(a.rows.size(), b.rows.size());
    for (std::size_t i = 0; i < a.rows.size(); ++i) {
      EXPECT_EQ(a.rows[i].is_missing, b.rows[i].is_missing) << i;
      EXPECT_EQ(a.rows[i].raw.acquisition_ns, b.rows[i].raw.acquisition_ns) << i;
      EXPECT_EQ(a.rows[i].raw.encoder_count, b.rows[i].raw.encoder_count) << i;
      EXPECT_EQ(a.rows[i].raw.force_V, b.rows[i].raw.force_V) << i;
    }
  }

  /// What is in the folder that holds the dataset.
  [[nodiscard]] std::size_t entries_beside() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
};

TEST_F(DatasetWriter, GivesIdenticalNumbersBack) {
  const std::vector<Recording> recordings = {raw_recording(), ankle_recording()};
  const auto written = write_dataset(root_, recordings);
  ASSERT_TRUE(written) << written.error().message;
  const auto read = read_dataset(root_);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  expect_same(recordings[0], (*read)[0]);
  expect_same(recordings[1], (*read)[1]);
  EXPECT_EQ(entries_beside(), 1U);
}

TEST_F(DatasetWriter, GivesReferenceContractionsBackBesideThePerturbationsAndNamesTheirType) {
  Recording recording = raw_recording();
  PerturbationEvent contraction;
  contraction.onset_s = 0.7;
  contraction.duration_s = 0.1;
  contraction.trial = 3;
  contraction.instruction = "contract";
  contraction.is_valid = false;
  contraction.reason = "aborted";
  contraction.trial_onset_s = 0.6;
  contraction.trial_duration_s = 0.25;
  recording.contractions = {contraction};
  ASSERT_TRUE(write_dataset(root_, {recording}));
  const auto read = read_dataset(root_);
  ASSERT_TRUE(read) << read.error().message;
  expect_same(recording, read->front());
  const std::string stem = "sub-01/ses-01/motion/sub-01_ses-01_task-unloaded_acq-farleft_run-12_events";
  EXPECT_THAT(*read_text_file(root_ / (stem + ".json")), ::testing::HasSubstr("\"reference_contraction\""));
  EXPECT_THAT(*read_text_file(root_ / (stem + ".tsv")),
              ::testing::HasSubstr("0.7\t0.1\treference_contraction\t3\tn/a"));
}

TEST_F(DatasetWriter, GivesIdenticalNumbersBackOfARawOneAxisRig) {
  Recording recording = ankle_recording();
  recording.is_raw = true;
  recording.rig.counts_per_unit[0] = 4096 / 3.0;
  recording.rig.force_saturation_V = 5;
  recording.rig.force_calibration(0, 0) = -2.5;
  recording.rig.force_offset_V[0] = 0.1;
  recording.channel_names = {"q1", "f1"};
  recording.tracked_point = "hand";
  ASSERT_TRUE(write_dataset(root_, {recording}));
  const auto read = read_dataset(root_);
  ASSERT_TRUE(read) << read.error().message;
  expect_same(recording, read->front());
}

TEST_F(DatasetWriter, WritesConvertedChannelsBesideRawOnes) {
  const Recording recording = raw_recording();
  ASSERT_TRUE(write_dataset(root_, {recording}));
  const std::string stem =
      "sub-01/ses-01/motion/sub-01_ses-01_task-unloaded_tracksys-manipulandum_acq-farleft_run-12";
  // Without the raw channels' names the reader takes the converted ones.
  std::string channels = content(root_ / (stem + "_channels.tsv"));
  for (const std::string name : {"q1", "q2", "f1", "f2"})
    channels.replace(channels.find("\n" + name) + 1, 1, name[0] == 'q' ? "-" : "+");
  put(stem + "_channels.tsv", channels);
  const auto read = read_dataset(root_);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->front().rig.kind, RigKind::kCartesian);
  const EndpointSample expected = convert(recording.rig, recording.shoulder, recording.rows[3].raw);
  const EndpointSample converted = convert(read->front().rig, {}, read->front().rows[3].raw);
  EXPECT_EQ(converted.p_SE, expected.p_SE);
  EXPECT_EQ(converted.f_S, expected.f_S);
}

TEST_F(DatasetWriter, ConvertsWhatHasScalesOfItsOwn) {
  Recording recording = raw_recording();
  recording.is_raw = false;
  recording.rig.kind = RigKind::kCartesian;
  ASSERT_TRUE(write_dataset(root_, {recording}));
  const auto read = read_dataset(root_);
  ASSERT_TRUE(read) << read.error().message;
  const EndpointSample expected = convert(recording.rig, recording.shoulder, recording.rows[3].raw);
  const EndpointSample converted = convert(read->front().rig, {}, read->front().rows[3].raw);
  EXPECT_EQ(converted.p_SE, expected.p_SE);
  EXPECT_EQ(converted.f_S, expected.f_S);
}

TEST_F(DatasetWriter, RefusesAPathThatIsThere) {
  fs::create_directories(root_);
  const auto written = write_dataset(root_, {ankle_recording()});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kAlreadyExists);
  EXPECT_TRUE(fs::is_empty(root_));
}

TEST_F(DatasetWriter, LeavesNothingWhenARecordingIsRefused) {
  Recording bad = raw_recording();
  bad.rows[9].raw.force_V[1] = std::numeric_limits<double>::quiet_NaN();
  const auto written = write_dataset(root_, {ankle_recording(), bad});
  ASSERT_FALSE(written);
  EXPECT_EQ(
      written.error().message,
      "recording sub-01 ses-01 run 12 (far left): has a row that is neither finite nor marked as missing");
  EXPECT_EQ(entries_beside(), 0U);
}

TEST_F(DatasetWriter, RefusesLabelsThatStandTwice) {
  const auto written = write_dataset(root_, {ankle_recording(), ankle_recording()});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().message,
            "recording sub-02 run 1: labels 'sub-02_task-ankle_run-01' occur twice; expected once");
  EXPECT_EQ(entries_beside(), 0U);
}

TEST_F(DatasetWriter, RefusesLabelsThatBidsDoesNotAllow) {
  Recording recording = ankle_recording();
  recording.task = "two words";
  const auto written = write_dataset(root_, {recording});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().message,
            "recording sub-02 run 1: task 'two words' is not allowed; expected letters and digits");
}

TEST_F(DatasetWriter, NamesAParentThatIsMissing) {
  const auto written = write_dataset(root_ / "deeper", {ankle_recording()});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kNotFound);
}

TEST(Labels, AreDistinctForDistinctNames) {
  std::set<std::string> labels;
  const std::vector<std::string> names = {"P 01",   "P-01",  "P_01", "P01", "山田",     "山本",
                                          "Müller", "Mller", "-",    "_",   "far-left", "farleft"};
  for (const std::string& name : names) {
    const std::string label = to_label(name);
    EXPECT_TRUE(labels.insert(label).second) << name << ": " << label;
    EXPECT_TRUE(
        std::all_of(label.begin(), label.end(), [](unsigned char c) { return std::isalnum(c) != 0; }));
    EXPECT_FALSE(label.empty());
  }
  EXPECT_EQ(to_label("P01"), "P01");
  EXPECT_EQ(to_label(""), "");
}

}  // namespace
}  // namespace tonus::recording
