#include "services/recording/dataset.hpp"
#include "services/recording/inherited_files.hpp"
#include "tests/unit/services/recording/dataset_folder.hpp"

/// Datasets as others write them.
namespace tonus::recording {
namespace {

class ForeignDataset : public testing::DatasetFolder {
 protected:
  /// A further one-axis run beside kOneAxisStem's.
  void put_run(const std::string& stem, const std::string& rows = "1\t1\n2\t2\n3\t3\n4\t4\n") {
    put(stem + "_motion.json", content(root_ / (kOneAxisStem + "_motion.json")));
    put(stem + "_channels.tsv", content(root_ / (kOneAxisStem + "_channels.tsv")));
    put(stem + "_motion.tsv", rows);
  }

  std::vector<Recording> read() {
    auto recordings = read_dataset(root_);
    EXPECT_TRUE(recordings) << recordings.error().message;
    return recordings ? std::move(*recordings) : std::vector<Recording>();
  }

  Dataset opened() {
    auto dataset = Dataset::open(root_, Imperfect::kLeftOut);
    EXPECT_TRUE(dataset) << dataset.error().message;
    return std::move(dataset).value();
  }
};

TEST_F(ForeignDataset, InheritsWhatTheFoldersAboveStateAndOverridesItByTheMoreSpecial) {
  put_one_axis();
  for (const char* name : {"_motion.json", "_channels.tsv"})
    std::filesystem::remove(root_ / (kOneAxisStem + name));
  put("task-hold_motion.json", R"({"SamplingFrequency": 500, "TaskDescription": "of all"})");
  put("sub-07/sub-07_motion.json", R"({"SamplingFrequency": 250})");
  put("task-other_motion.json", R"({"SamplingFrequency": 1})");
  put("task-hold_channels.json", R"({"Rig": {"Axes": 1, "ForceSign": -1}})");
  put("task-hold_tracksys-servo_channels.tsv", "name\ttype\tunits\nangle\tJNTANG\trad\ntorque\tMISC\tN m\n");
  put("task-hold_events.tsv", "onset\tduration\n0\t0.004\n");
  const auto recordings = read();
  ASSERT_EQ(recordings.size(), 1U);
  EXPECT_EQ(recordings[0].sampling_frequency, 250.0);
  EXPECT_EQ(recordings[0].task_description, "of all");
  EXPECT_EQ(recordings[0].rig.force_calibration(0, 0), -1.0);
  EXPECT_EQ(recordings[0].events[0].duration_s, 0.004);
}

TEST_F(ForeignDataset, RefusalNamesTheFileThatStatesTheValue) {
  put_one_axis();
  std::filesystem::remove(root_ / (kOneAxisStem + "_motion.json"));
  put("task-hold_motion.json", R"({"SamplingFrequency": -3})");
  const auto refused = read_dataset(root_);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("/task-hold_motion.json: SamplingFrequency = -3"), std::string::npos)
      << refused.error().message;
}

TEST_F(ForeignDataset, TakesTruthsWholeNumbersAgesAndLabelsAsProgramsWriteThem) {
  put_one_axis();
  put("participants.tsv", "participant_id\tage\nsub-07\t89+\n");
  put(kOneAxisStem + "_events.tsv",
      "onset\tduration\ttrial\tset\tvalid\n0\t0.001\t1.0\t2.0\tTrue\n0.001\t0.001\t2.0\t2.0\t0.0\n");
  put_run("sub-07/motion/sub-07_task-hold+fast_tracksys-servo_run-02");
  const auto recordings = read();
  ASSERT_EQ(recordings.size(), 2U);
  EXPECT_EQ(recordings[1].task, "hold+fast");
  EXPECT_EQ(recordings[0].participant.age, 89.0);
  EXPECT_TRUE(recordings[0].participant.is_age_or_more);
  const auto& events = recordings[0].events;
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].trial, 1);
  EXPECT_EQ(events[0].set, 2);
  EXPECT_TRUE(events[0].is_valid);
  EXPECT_FALSE(events[1].is_valid);
}

TEST_F(ForeignDataset, NumbersTrialsOnThroughTheRunsOfASessionWhereNoColumnDoes) {
  put_one_axis();
  put(kOneAxisStem + "_events.tsv", "onset\tduration\n0\t0.001\n0.001\t0.001\n");
  const std::string other = "sub-07/motion/sub-07_task-hold_tracksys-servo_run-01";
  put_run(other);
  put(other + "_events.tsv", "onset\tduration\n0\t0.001\n0.001\t0.001\n");
  const auto recordings = read();
  ASSERT_EQ(recordings.size(), 2U);
  EXPECT_EQ(recordings[0].events[1].trial, 2);
  EXPECT_EQ(recordings[1].events[0].trial, 3);
  EXPECT_EQ(recordings[1].events[1].trial, 4);
}

TEST_F(ForeignDataset, LeavesOutByNameTheRunsOfATrackingSystemWithoutForceAndKeepsTheOthers) {
  put_one_axis();
  const std::string imu = "sub-07/motion/sub-07_task-hold_tracksys-imu_run-02";
  put_run(imu);
  put(imu + "_channels.tsv", "name\ttype\tunits\nax\tACCEL\tm/s^2\nay\tACCEL\tm/s^2\n");
  put("sub-07/motion/sub-07_task-hold_run-02_events.tsv", "onset\tduration\ttrial\n0\t0.001\t1\n");
  const Dataset dataset = opened();
  ASSERT_EQ(dataset.runs(), 1U);
  EXPECT_EQ(dataset.read(0).value().tracking_system, "servo");
  ASSERT_EQ(dataset.left_out().size(), 1U);
  EXPECT_NE(dataset.left_out()[0].find(imu), std::string::npos) << dataset.left_out()[0];
  EXPECT_NE(dataset.left_out()[0].find("without a force"), std::string::npos) << dataset.left_out()[0];
}

TEST_F(ForeignDataset, TakesTwoTrackingSystemsThatShareTheirTrials) {
  put_one_axis();
  put_run("sub-07/motion/sub-07_task-hold_tracksys-optical_run-02");
  put("sub-07/motion/sub-07_task-hold_run-02_events.tsv", "onset\tduration\ttrial\n0\t0.001\t1\n");
  const Dataset dataset = opened();
  ASSERT_EQ(dataset.runs(), 2U);
  EXPECT_TRUE(dataset.left_out().empty());
  EXPECT_EQ(dataset.read(0).value().events[0].trial, 1);
  EXPECT_EQ(dataset.read(1).value().events[0].trial, 1);
}

TEST_F(ForeignDataset, LeavesOutOneImperfectItemOfEveryKindByName) {
  put_one_axis();
  put("participants.tsv", "participant_id\tage\tforearm_m\nsub-07\told\t0.31\n");
  put("sub-07/motion/sub-07_task-hold_run-03_motion.tsv", "1\t2\n");
  put("sub-08/sub-08_task-hold_tracksys-servo_motion.tsv", "1\t2\n");
  put_run("sub-09/motion/sub-09_task-hold_tracksys-servo");
  put(kOneAxisStem + "_events.tsv",
      "onset\tduration\tvalid\n0\t0.001\ttrue\n0\t0.001\tmaybe\n0\t9\ttrue\nn/a\t0.001\ttrue\n");
  const Dataset dataset = opened();
  ASSERT_EQ(dataset.runs(), 2U);
  const auto recording = dataset.read(0);
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->participant.forearm_m, 0.31);
  EXPECT_FALSE(recording->participant.age);
  int valid = 0;
  for (const auto& event : recording->events) {
    valid += event.is_valid ? 1 : 0;
    if (event.is_valid) continue;
    EXPECT_NE(event.reason.find("is not allowed; expected"), std::string::npos) << event.reason;
  }
  EXPECT_EQ(recording->events.size(), 4U);
  EXPECT_EQ(valid, 1);
  std::string all;
  for (const auto& line : dataset.left_out()) all += line + "\n";
  EXPECT_EQ(dataset.left_out().size(), 4U) << all;
  for (const char* name :
       {"'old' is not allowed", "sub-07_task-hold_run-03_motion.tsv", "participant 'sub-09' is missing",
        "sub-08_task-hold_tracksys-servo_motion.tsv: a recording is not allowed here"})
    EXPECT_NE(all.find(name), std::string::npos) << name << "\n" << all;
}

TEST_F(ForeignDataset, WithoutAnyRunThatCanBeReadIsRefusedByTheFirstReason) {
  put_one_axis();
  put(kOneAxisStem + "_motion.json", "{}");
  const auto refused = Dataset::open(root_, Imperfect::kLeftOut);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("SamplingFrequency is missing"), std::string::npos);
}

TEST_F(ForeignDataset, AnAgeOfAtLeastSoManyYearsIsWrittenAsItWasRead) {
  put_one_axis();
  put("participants.tsv", "participant_id\tage\nsub-07\t89+\n");
  const auto recordings = read();
  ASSERT_TRUE(write_dataset(folder_ / "copy", recordings));
  EXPECT_NE(content(folder_ / "copy" / "participants.tsv").find("89+"), std::string::npos);
}

TEST_F(ForeignDataset, TakesChannelsInTheUnitsThatProgramsWrite) {
  put_one_axis();
  put(kOneAxisStem + "_channels.tsv",
      "name\ttype\tunits\nangle\tJNTANG\tdeg\ntorque\tMISC\tN mm\nt\tLATENCY\tms\n");
  put(kOneAxisStem + "_motion.tsv", "180\t-2\t0\n90\t3e3\t1\n");
  const auto recordings = read();
  ASSERT_EQ(recordings.size(), 1U);
  EXPECT_EQ(recordings[0].displacement_unit, "rad");
  EXPECT_EQ(recordings[0].force_unit, "N m");
  EXPECT_NEAR(recordings[0].rows[0].raw.encoder_count[0], 3.14159265358979, 1e-12);
  EXPECT_NEAR(recordings[0].rows[0].raw.force_V[0], -0.002, 1e-15);
  EXPECT_NEAR(recordings[0].rows[1].raw.force_V[0], 3.0, 1e-12);
}

TEST_F(ForeignDataset, ImportAndReplayLeaveOutWhatIdentificationLeavesOut) {
  put_one_axis();
  put("sub-07/motion/sub-07_task-hold_run-03_motion.tsv", "1\t2\n");
  put_run("sub-07/motion/sub-07_task-hold_tracksys-servo_run-04", "1\tbroken\n");
  const auto usable = read_usable(root_);
  ASSERT_TRUE(usable) << usable.error().message;
  const Dataset dataset = opened();
  ASSERT_EQ(usable->recordings.size(), 1U);
  ASSERT_EQ(usable->left_out.size(), dataset.left_out().size() + 1);
  EXPECT_EQ(usable->left_out.front(), dataset.left_out().front());
  EXPECT_NE(usable->left_out.back().find("'broken' is not allowed"), std::string::npos)
      << usable->left_out.back();
}

TEST_F(ForeignDataset, AForceSignThatOneRecordingRefusesLeavesItOut) {
  put_one_axis();
  UsableRecordings usable = read_usable(root_).value();
  usable.recordings.push_back(usable.recordings.front());
  usable.recordings.back().is_raw = true;
  ASSERT_TRUE(state_force_sign(usable, -1));
  ASSERT_EQ(usable.recordings.size(), 1U);
  EXPECT_EQ(usable.recordings[0].rig.force_calibration(0, 0), -1.0);
  EXPECT_EQ(usable.left_out.size(), 1U);
  usable.recordings[0].is_raw = true;
  EXPECT_FALSE(state_force_sign(usable, -1));
}

TEST_F(ForeignDataset, AReplayPlaysTheEventsOfARecordThatCountAndNothingElse) {
  put_one_axis();
  put(kOneAxisStem + "_motion.tsv", "1\t1\n2\t2\n3\t3\n4\t4\n5\t5\n6\t6\n");
  put(kOneAxisStem + "_events.tsv",
      "onset\tduration\tvalid\n0.001\t0.001\ttrue\n0.003\t0.001\ttrue\n0\t0.001\tfalse\n");
  UsableRecordings usable = read_usable(root_).value();
  const auto whole = usable.recordings[0];
  ASSERT_TRUE(keep_what_counts(usable));
  const Recording& cut = usable.recordings[0];
  ASSERT_EQ(usable.left_out.size(), 1U);
  EXPECT_NE(usable.left_out[0].find("flagged invalid"), std::string::npos) << usable.left_out[0];
  const Stretch first = stretch_of(whole, whole.events[1]);
  const Stretch last = stretch_of(whole, whole.events[2]);
  ASSERT_EQ(cut.rows.size(), last.last - first.first + 1);
  ASSERT_EQ(cut.events.size(), 1U);
  for (std::size_t i = 0; i < cut.rows.size(); ++i) {
    const std::size_t row = first.first + i;
    const bool is_used = row <= first.last || row >= last.first;
    EXPECT_EQ(cut.rows[i].is_missing, !is_used) << row;
    if (!is_used) continue;
    EXPECT_EQ(cut.rows[i].raw.encoder_count[0], whole.rows[row].raw.encoder_count[0]);
  }
}

}  // namespace
}  // namespace tonus::recording
