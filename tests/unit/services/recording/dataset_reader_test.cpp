#include <cmath>
#include <numbers>

#include "services/recording/dataset.hpp"
#include "tests/unit/services/recording/dataset_folder.hpp"

namespace tonus::recording {
namespace {

using DatasetReader = testing::DatasetFolder;

TEST_F(DatasetReader, TakesLabelsRigAndRowsOfARawRecording) {
  put_raw();
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  ASSERT_EQ(recordings->size(), 1U);
  const Recording& recording = recordings->front();
  EXPECT_EQ(recording.participant.id, "sub-01");
  EXPECT_EQ(recording.session, "ses-02");
  EXPECT_EQ(recording.task, "unloaded");
  EXPECT_EQ(recording.tracking_system, "manipulandum");
  EXPECT_EQ(recording.acquisition, "left");
  EXPECT_EQ(recording.run, 3);
  EXPECT_EQ(recording.posture, "left");
  EXPECT_EQ(recording.posture_position, Eigen::Vector2d(-0.295, 0.38));
  EXPECT_EQ(recording.sampling_frequency, 200.0);
  EXPECT_TRUE(recording.is_raw);
  EXPECT_EQ(recording.rig.kind, RigKind::kTwoLink);
  EXPECT_EQ(recording.rig.links.l2, 0.35);
  EXPECT_DOUBLE_EQ(recording.rig.counts_per_unit[1], 4000 / (2 * std::numbers::pi));
  EXPECT_EQ(recording.rig.encoder_zero[1], 1000);
  EXPECT_EQ(recording.rig.encoder_sign[1], -1);
  EXPECT_EQ(recording.rig.force_calibration(0, 1), 0.5);
  EXPECT_EQ(recording.rig.force_offset_V[1], 0.25);
  EXPECT_EQ(recording.rig.force_sensor_angle, 0.1);
  EXPECT_EQ(recording.rig.handle_mass, 0.2);
  EXPECT_EQ(recording.shoulder.origin, Eigen::Vector2d(0.05, -0.10));
  EXPECT_EQ(recording.shoulder.angle, 0.2);
  ASSERT_EQ(recording.rows.size(), 3U);
  EXPECT_EQ(recording.rows[2].raw.encoder_count[1], 2002);
  EXPECT_EQ(recording.rows[2].raw.force_V[1], -1.25);
  EXPECT_EQ(recording.rows[2].raw.acquisition_ns, 10'000'000);  // two samples at 200 Hz
}

TEST_F(DatasetReader, TakesRawChannelsWhereConvertedOnesAreBesideThem) {
  put_raw();
  put(kRawStem + "_channels.tsv",
      "name\ttype\tunits\nx\tPOS\tm\ny\tPOS\tm\nfx\tMISC\tN\nfy\tMISC\tN\n"
      "q1\tMISC\tcount\nq2\tMISC\tcount\nf1\tMISC\tV\nf2\tMISC\tV\n");
  put(kRawStem + "_motion.tsv", "9\t9\t9\t9\t1\t2\t3\t4\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  EXPECT_TRUE(recordings->front().is_raw);
  EXPECT_EQ(recordings->front().rows[0].raw.encoder_count[1], 2);
  EXPECT_EQ(recordings->front().rows[0].raw.force_V[0], 3);
}

TEST_F(DatasetReader, GivesConvertedChannelsUnchangedThroughTheConversion) {
  put_raw();
  put(kRawStem + "_channels.tsv",
      "name\ttype\tunits\nfy\tMISC\tN\nx\tPOS\tm\nlight\tMISC\tlx\ny\tPOS\tm\nfx\tMISC\tN\nxc\tMISC\tm\nyc\tM"
      "ISC\tm\n");
  put(kRawStem + "_motion.tsv", "-0.75\t0.01\tdark\t0.38\t1.5\t0.005\t-0.005\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  const Recording& recording = recordings->front();
  EXPECT_FALSE(recording.is_raw);
  EXPECT_EQ(recording.rig.kind, RigKind::kCartesian);
  const EndpointSample endpoint = convert(recording.rig, recording.shoulder, recording.rows[0].raw);
  EXPECT_EQ(endpoint.p_SE, Eigen::Vector2d(0.01, 0.38));
  EXPECT_EQ(endpoint.f_S, Eigen::Vector2d(1.5, -0.75));
  ASSERT_EQ(recording.commanded.size(), 1U);
  EXPECT_EQ(recording.commanded[0][1], -0.005);
}

TEST_F(DatasetReader, TakesOneAxisChannelsByTypeAndUnit) {
  put_one_axis();
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  const Recording& recording = recordings->front();
  EXPECT_EQ(recording.rig.kind, RigKind::kOneAxis);
  EXPECT_EQ(recording.displacement_unit, "rad");
  EXPECT_EQ(recording.force_unit, "N m");
  EXPECT_EQ(recording.channel_names[1], "torque");
  EXPECT_EQ(recording.tracked_point, "ankle");
  const EndpointSample endpoint = convert(recording.rig, recording.shoulder, recording.rows[1].raw);
  EXPECT_EQ(endpoint.p_SE[0], 0.25);
  EXPECT_EQ(endpoint.f_S[0], 0.3);
  EXPECT_EQ(endpoint.p_SE[1], 0.0);
  EXPECT_EQ(endpoint.f_S[1], 0.0);
}

TEST_F(DatasetReader, TakesRawOneAxisChannels) {
  put_one_axis();
  put(kOneAxisStem + "_channels.tsv", "name\ttype\tunits\nq1\tMISC\tcount\nf1\tMISC\tV\n");
  put(kOneAxisStem + "_channels.json",
      R"({"Rig": {"Axes": 1, "EncoderCountsPerRevolution": [4096], "EncoderZero_count": [10], "EncoderSign": [-1],
          "ForceCalibration_N_per_V": [[-2.5]], "ForceOffset_V": [0.5]}})");
  put(kOneAxisStem + "_motion.tsv", "1034\t2.5\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  const Recording& recording = recordings->front();
  const EndpointSample endpoint = convert(recording.rig, recording.shoulder, recording.rows[0].raw);
  EXPECT_NEAR(endpoint.p_SE[0], -std::numbers::pi / 2, 1e-15);  // a quarter of 4096 counts, backwards
  EXPECT_EQ(endpoint.f_S[0], -5.0);                             // -2.5 (2.5 - 0.5)
}

TEST_F(DatasetReader, SaysWhetherTheSignOfAOneAxisForceIsStated) {
  put_one_axis();
  const auto unstated = read_dataset(root_);
  ASSERT_TRUE(unstated) << unstated.error().message;
  EXPECT_FALSE(unstated->front().is_force_sign_stated);
  EXPECT_EQ(unstated->front().rig.force_calibration(0, 0), 1.0);

  put(kOneAxisStem + "_channels.json", R"({"Rig": {"Axes": 1, "ForceSign": -1}})");
  const auto stated = read_dataset(root_);
  ASSERT_TRUE(stated) << stated.error().message;
  EXPECT_TRUE(stated->front().is_force_sign_stated);
  EXPECT_EQ(convert(stated->front().rig, {}, stated->front().rows[0].raw).f_S[0], 2.0);
}

TEST_F(DatasetReader, MarksARowWithNothingInAnyUsedColumnAsMissing) {
  put_raw();
  put(kRawStem + "_motion.tsv", "1\t2\t3\t4\n1\tn/a\t3\t4\nn/a\tn/a\tn/a\tn/a\n5\t6\t7\t8");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  const auto& rows = recordings->front().rows;
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_FALSE(rows[0].is_missing);
  EXPECT_TRUE(rows[1].is_missing);
  EXPECT_EQ(rows[1].raw.force_V[0], 0.0);
  EXPECT_EQ(rows[1].raw.acquisition_ns, 5'000'000);
  EXPECT_TRUE(rows[2].is_missing);
  EXPECT_FALSE(rows[3].is_missing);
  EXPECT_EQ(rows[3].raw.force_V[1], 8.0);
}

TEST_F(DatasetReader, TakesTheStatedMissingValueAsNothing) {
  put_one_axis();
  put(kOneAxisStem + "_motion.json", R"({"SamplingFrequency": 1000, "MissingValues": "-999"})");
  put(kOneAxisStem + "_motion.tsv", "1\t2\n3\t-999\n-999.0\t4\n5\tn/a\n6\t7\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  const auto& rows = recordings->front().rows;
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_FALSE(rows[0].is_missing);
  EXPECT_TRUE(rows[1].is_missing && rows[2].is_missing && rows[3].is_missing);
  EXPECT_FALSE(rows[4].is_missing);
}

TEST_F(DatasetReader, CommandThatIsNotKnownDoesNotMakeTheMeasuredRowMissing) {
  put_one_axis();
  put(kOneAxisStem + "_channels.tsv",
      "name\ttype\tunits\nangle\tJNTANG\trad\ntorque\tMISC\tN m\nxc\tMISC\trad\n");
  put(kOneAxisStem + "_motion.tsv", "1\t2\t0.5\n3\t4\tn/a\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  const Recording& recording = recordings->front();
  EXPECT_FALSE(recording.rows[1].is_missing);
  ASSERT_EQ(recording.commanded.size(), 2U);
  EXPECT_EQ(recording.commanded[0][0], 0.5);
  EXPECT_FALSE(std::isfinite(recording.commanded[1][0]));
}

TEST_F(DatasetReader, TakesNothingOfAnIgnoredColumnAsItStands) {
  put_one_axis();
  put(kOneAxisStem + "_channels.tsv",
      "name\ttype\tunits\nnote\tMISC\tn/a\nangle\tJNTANG\trad\ntorque\tMISC\tN*m\nemg\tMISC\tV\n");
  put(kOneAxisStem + "_motion.tsv", "n/a\t1\t2\tn/a\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  EXPECT_FALSE(recordings->front().rows[0].is_missing);
  EXPECT_EQ(recordings->front().rows[0].raw.force_V[0], 2.0);
}

TEST_F(DatasetReader, TakesWindowsLineEndsAndAByteOrderMark) {
  put_one_axis();
  put(kOneAxisStem + "_channels.tsv",
      "\xEF\xBB\xBFname\ttype\tunits\r\nangle\tJNTANG\trad\r\ntorque\tMISC\tN m\r\n");
  put(kOneAxisStem + "_motion.tsv", "1\t2\r\n3\tn/a\r\n5\t6\r\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  ASSERT_EQ(recordings->front().rows.size(), 3U);
  EXPECT_TRUE(recordings->front().rows[1].is_missing);
  EXPECT_EQ(recordings->front().rows[2].raw.force_V[0], 6.0);
}

TEST_F(DatasetReader, TakesEveryColumnOfTheEvents) {
  put_raw();
  put(kRawStem + "_events.tsv",
      "onset\tduration\ttrial_type\ttrial\tset\tdirection_deg\tamplitude_m\trise_time_s\tbias_x_N\tbias_y_"
      "N\tvalid\treason\n"
      "0.010\t0.005\tperturbation\t12\t2\t45\t0.005\t0.2\t0.7\t-0.1\tfalse\tmoved before onset\n"
      "0.005\t0.005\tpause\t11\t2\t45\t0.005\t0.2\t0\t0\ttrue\tn/a\n"
      "0\t0.005\tperturbation\t11\t1\t90\t0.006\t0.3\tn/a\tn/a\ttrue\tn/a\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  const auto& events = recordings->front().events;
  ASSERT_EQ(events.size(), 2U);
  const PerturbationEvent first{0.0, 0.005, 11, 1, 90.0, 0.006, 0.3, {0, 0}, true, ""};
  const PerturbationEvent second{0.01,  0.005, 12,          2,     45.0,
                                 0.005, 0.2,   {0.7, -0.1}, false, "moved before onset"};
  EXPECT_EQ(events[0], first);
  EXPECT_EQ(events[1], second);
}

TEST_F(DatasetReader, TakesEventsThatAllTrackingSystemsShare) {
  put_one_axis();
  put("sub-07/motion/sub-07_task-hold_run-02_events.tsv", "onset\tduration\ttrial\n0.001\t0.001\t42\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  ASSERT_EQ(recordings->front().events.size(), 1U);
  EXPECT_EQ(recordings->front().events[0].trial, 42);
}

TEST_F(DatasetReader, TakesARecordWithoutEventsAsOneContinuousPerturbation) {
  put_one_axis();
  put("sub-07/motion/sub-07_task-hold_run-02_events.tsv", "onset\tduration\ttrial\n0.001\t0.001\t42\n");
  const std::string other = "sub-07/motion/sub-07_task-hold_tracksys-servo_run-01";
  put(other + "_motion.json", content(root_ / (kOneAxisStem + "_motion.json")));
  put(other + "_channels.tsv", content(root_ / (kOneAxisStem + "_channels.tsv")));
  put(other + "_motion.tsv", "1\t1\n2\t2\n3\t3\n4\t4\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  ASSERT_EQ(recordings->size(), 2U);
  EXPECT_EQ((*recordings)[0].run, 1);
  ASSERT_EQ((*recordings)[0].events.size(), 1U);
  const PerturbationEvent& event = (*recordings)[0].events[0];
  EXPECT_TRUE(event.is_continuous());
  EXPECT_EQ(event.onset_s, 0.0);
  EXPECT_EQ(event.duration_s, 0.004);
  EXPECT_EQ(event.trial, 43);  // next after the other run's 42
}

TEST_F(DatasetReader, TakesWhatIsKnownOfTheParticipant) {
  put_raw();
  put("participants.tsv",
      "participant_id\tage\tupper_arm_m\tforearm_m\thandedness\tsex\nsub-09\t1\t1\t1\tleft\tF\nsub-01\t34\t0."
      "31\tn/a\tright\tn/a\n");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  const Participant& participant = recordings->front().participant;
  EXPECT_EQ(participant.upper_arm_m, 0.31);
  EXPECT_EQ(participant.forearm_m, std::nullopt);
  EXPECT_EQ(participant.age, 34.0);
  EXPECT_EQ(participant.handedness, "right");
  EXPECT_EQ(participant.sex, "");
}

}  // namespace
}  // namespace tonus::recording
