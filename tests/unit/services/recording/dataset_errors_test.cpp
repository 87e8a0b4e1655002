#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "services/recording/dataset.hpp"
#include "tests/unit/services/recording/dataset_folder.hpp"

/// Every refusal is one line that names the file, the place, the value and what is allowed.
namespace tonus::recording {
namespace {

class DatasetErrors : public testing::DatasetFolder {
 protected:
  /// The message of reading the dataset, with the root's path left out.
  std::string refusal() {
    const auto recordings = read_dataset(root_);
    if (recordings) return "nothing refused";
    std::string message = recordings.error().message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    const std::string prefix = root_.string() + "/";
    if (message.starts_with(prefix)) message.erase(0, prefix.size());
    return message;
  }

  std::string refusal_of(const std::string& name, const std::string& text) {
    put(name, text);
    return refusal();
  }
};

TEST_F(DatasetErrors, NameAMissingFolder) {
  EXPECT_EQ(refusal(),
            "dataset '" + root_.string() + "': no such folder; expected the root of a BIDS dataset");
}

TEST_F(DatasetErrors, NameAFolderThatIsNoDataset) {
  std::filesystem::create_directories(root_);
  EXPECT_EQ(refusal(),
            "dataset '" + root_.string() + "': is not a BIDS dataset: dataset_description.json is missing");
}

TEST_F(DatasetErrors, StateBothRatesWhereTimeStampsContradictTheStatedOne) {
  put_one_axis();
  put(kOneAxisStem + "_channels.tsv",
      "name\ttype\tunits\nangle\tJNTANG\trad\ntorque\tMISC\tN m\nlatency\tLATENCY\ts\n");
  EXPECT_EQ(
      refusal_of(kOneAxisStem + "_motion.tsv", "1\t2\t0\n3\t4\t0.002\n5\t6\t0.004\n"),
      kOneAxisStem +
          "_motion.tsv: time stamps of 500 Hz are not allowed; expected 1000 Hz, as _motion.json states");
  EXPECT_EQ(refusal_of(kOneAxisStem + "_motion.tsv", "1\t2\t0\n3\t4\tn/a\n5\t6\t0.002\n"), "nothing refused");
  EXPECT_EQ(refusal_of(kOneAxisStem + "_motion.tsv", "1\t2\t0\n3\t4\t0.0019\n5\t6\t0.002\n7\t8\t0.003\n"),
            kOneAxisStem +
                "_motion.tsv:2: a time stamp 0.0019 s after the first is not allowed; expected 0.001 s, as "
                "rows are equally spaced");
}

TEST_F(DatasetErrors, StateBothRatesWhereTheEffectiveOneOrAChannelsContradictsTheNominalOne) {
  put_one_axis();
  const std::string json = kOneAxisStem + "_motion.json";
  EXPECT_EQ(
      refusal_of(json, R"({"SamplingFrequency": 1000, "SamplingFrequencyEffective": 500})"),
      json +
          ": SamplingFrequencyEffective = 500 is not allowed; expected within 10 % of the SamplingFrequency, "
          "1000 Hz");
  put(json, R"({"SamplingFrequency": 1000, "SamplingFrequencyEffective": 998.5})");
  const auto recordings = read_dataset(root_);
  ASSERT_TRUE(recordings) << recordings.error().message;
  EXPECT_EQ(recordings->front().sampling_frequency, 998.5);
  const std::string message =
      refusal_of(kOneAxisStem + "_channels.tsv",
                 "name\ttype\tunits\tsampling_frequency\nangle\tJNTANG\trad\t1000\ntorque\tMISC\tN m\t100\n");
  EXPECT_NE(message.find("'100' is not allowed"), std::string::npos) << message;
  EXPECT_NE(message.find("1000 Hz, the SamplingFrequency"), std::string::npos) << message;
}

TEST_F(DatasetErrors, StateBothDurationsWhereTheRowsContradictTheRecordingDuration) {
  put_one_axis();
  std::string rows;
  for (int i = 0; i < 500; ++i) rows += "1\t2\n";
  put(kOneAxisStem + "_motion.tsv", rows);
  const std::string json = kOneAxisStem + "_motion.json";
  EXPECT_EQ(refusal_of(json, R"({"SamplingFrequency": 1000, "RecordingDuration": 1})"),
            kOneAxisStem +
                "_motion.tsv: 500 rows at 1000 Hz, 0.5 s, are not allowed; expected 1 s, the "
                "RecordingDuration of _motion.json");
  EXPECT_EQ(refusal_of(json, R"({"SamplingFrequency": 1000, "RecordingDuration": 0.5})"), "nothing refused");
}

TEST_F(DatasetErrors, NameAChannelThatOccursTwice) {
  put_one_axis();
  const std::string message =
      refusal_of(kOneAxisStem + "_channels.tsv",
                 "name\ttype\tunits\nangle\tJNTANG\trad\ntorque\tMISC\tN m\nangle\tMISC\tV\n");
  EXPECT_NE(message.find("every name once"), std::string::npos) << message;
}

TEST_F(DatasetErrors, NameADatasetWithoutRecordings) {
  EXPECT_EQ(refusal_of("dataset_description.json", "{}"),
            "dataset '" + root_.string() + "': has no recording; expected sub-*/[ses-*/]motion/*_motion.tsv");
}

TEST_F(DatasetErrors, NameABadFileName) {
  put_one_axis();
  EXPECT_EQ(refusal_of("sub-07/motion/sub-07_task-hold_run-01_motion.tsv", "1\n"),
            "sub-07/motion/sub-07_task-hold_run-01_motion.tsv: file name is not allowed; expected "
            "tracksys-<label>");
}

TEST_F(DatasetErrors, NameTheSidecarThatIsMissing) {
  put_one_axis();
  std::filesystem::remove(root_ / (kOneAxisStem + "_motion.json"));
  EXPECT_EQ(refusal(), kOneAxisStem + "_motion.json: cannot be read: No such file or directory");
  put_one_axis();
  std::filesystem::remove(root_ / (kOneAxisStem + "_channels.tsv"));
  EXPECT_EQ(refusal(), kOneAxisStem + "_channels.tsv: cannot be read: No such file or directory");
}

TEST_F(DatasetErrors, NameThePlaceOfBrokenJson) {
  put_one_axis();
  const std::string message = refusal_of(kOneAxisStem + "_motion.json", "{\"TaskName\": \"hold\",\n  oops}");
  EXPECT_TRUE(
      message.starts_with(kOneAxisStem + "_motion.json: is not JSON: parse error at line 2, column 3"))
      << message;
}

TEST_F(DatasetErrors, SurviveJsonThatIsNestedWithoutEnd) {
  put_one_axis();
  const std::string open(200000, '[');
  const std::string close(200000, ']');
  EXPECT_EQ(refusal_of(kOneAxisStem + "_motion.json", "{\"SamplingFrequency\": " + open + close + "}"),
            kOneAxisStem +
                "_motion.json: SamplingFrequency = [[[[[[[[[[[[[[[]]]]]]]]]]]]]]] is not allowed; expected a "
                "number");
}

TEST_F(DatasetErrors, NameASamplingFrequencyThatIsNotAllowed) {
  put_one_axis();
  const std::string file = kOneAxisStem + "_motion.json";
  EXPECT_EQ(refusal_of(file, "{}"), file + ": SamplingFrequency is missing; expected a number");
  EXPECT_EQ(refusal_of(file, R"({"SamplingFrequency": "fast"})"),
            file + ": SamplingFrequency = \"fast\" is not allowed; expected a number");
  EXPECT_EQ(refusal_of(file, R"({"SamplingFrequency": 0})"),
            file + ": SamplingFrequency = 0 is not allowed; expected more than 0 and up to 1000000 Hz");
}

TEST_F(DatasetErrors, NameLineAndColumnOfABadNumber) {
  put_one_axis();
  const std::string file = kOneAxisStem + "_motion.tsv";
  EXPECT_EQ(refusal_of(file, "1\t2\n3\tfour\n"),
            file + ":2: column '2': 'four' is not allowed; expected a number or n/a");
  EXPECT_EQ(refusal_of(file, "1,5\t2\n"),
            file + ":1: column '1': '1,5' is not allowed; expected a number or n/a");
  EXPECT_EQ(refusal_of(file, "1\tnan\n"),
            file + ":1: column '2': 'nan' is not allowed; expected a number or n/a");
  EXPECT_EQ(refusal_of(file, "1\t1e999\n"),
            file + ":1: column '2': '1e999' is not allowed; expected a number or n/a");
  EXPECT_EQ(refusal_of(file, "1\t2\n\t2\n"),
            file + ":2: column '1': '' is not allowed; expected a number or n/a");
}

TEST_F(DatasetErrors, NameALineWithAnotherNumberOfCells) {
  put_one_axis();
  const std::string file = kOneAxisStem + "_motion.tsv";
  const std::string needed = " cells are not allowed; expected 2, one for each line of _channels.tsv";
  EXPECT_EQ(refusal_of(file, "1\t2\n3\n"), file + ":2: 1" + needed);
  EXPECT_EQ(refusal_of(file, "1\t2\t3\n"), file + ":1: 3 or more" + needed);
  EXPECT_EQ(refusal_of(file, ""), file + ": is empty; expected a row");
}

TEST_F(DatasetErrors, OfMotionWithoutAForceAreOneLineThatAPersonCanReadAndActOn) {
  put_one_axis();
  const std::string file = kOneAxisStem + "_channels.tsv";
  std::string imu = "name\tcomponent\ttype\ttracked_point\tunits\n";
  for (int point = 0; point < 51; ++point) {
    for (const char* axis : {"x", "y", "z"})
      imu += "p" + std::to_string(point) + "_ACCEL_" + axis + "\t" + axis + "\tACCEL\tp\tm/s^2\n";
  }
  const std::string of_imu = refusal_of(file, imu);
  EXPECT_LT(of_imu.size(), 500U);
  EXPECT_NE(of_imu.find("p2_ACCEL_x, p2_ACCEL_y and 145 more are not allowed"), std::string::npos) << of_imu;
  EXPECT_NE(of_imu.find("without a force nothing can be identified: leave"), std::string::npos) << of_imu;
  const std::string of_rigid_body =
      refusal_of(file,
                 "name\tcomponent\ttype\ttracked_point\tunits\n"
                 "head_quat_w\tquat_w\tORNT\thead\tn/a\nhead_cart_x\tx\tPOS\thead\tm\n"
                 "head_yaw\tn/a\tMISC\thead\tn/a\nlatency\tn/a\tLATENCY\tn/a\tseconds\n");
  EXPECT_NE(of_rigid_body.find("without a force"), std::string::npos) << of_rigid_body;
}

TEST_F(DatasetErrors, NameARecordingThatLiesWhereItWouldNotBeRead) {
  put_one_axis();
  const std::string rest =
      ": a recording is not allowed here; expected sub-*/[ses-*/]motion/sub-*_motion.tsv, not compressed";
  const std::string name = "sub-08_task-hold_tracksys-servo_motion.tsv";
  for (const std::string& place :
       {"sub-08/" + name, "sub-08/motion/" + name + ".gz", "sub-08/ses-1/" + name, name, "08/motion/" + name,
        "sub-08/ses-1/run-1/motion/" + name, std::string("sub-08/motion/motion.tsv")}) {
    EXPECT_EQ(refusal_of(place, "1\t2\n"), place + rest);
    std::filesystem::remove(root_ / place);
  }
  for (const std::string folder : {"sourcedata", "derivatives", "code", ".git"})
    EXPECT_EQ(refusal_of(folder + "/" + name, "1\t2\n"), "nothing refused");
}

TEST_F(DatasetErrors, NameChannelsThatCannotBeUsed) {
  put_one_axis();
  const std::string file = kOneAxisStem + "_channels.tsv";
  EXPECT_EQ(refusal_of(file, "name\ttype\tunits\nangle\tJNTANG\trad\nemg\tMISC\tV\n"),
            file +
                ": channels angle, emg are not allowed: needed are q1, q2, f1, f2, or x, y, fx, fy, or one "
                "channel of "
                "type JNTANG or POS and one of type MISC in N or N m");
  EXPECT_EQ(refusal_of(file, "name\ttype\tunits\nangle\tJNTANG\tpx\ntorque\tMISC\tN m\n"),
            file + ":2: column 'units': 'px' is not allowed; expected 'm' or 'rad'");
  EXPECT_EQ(refusal_of(file, "name\ttype\tunits\nangle\tJNTANG\trad\nforce\tMISC\tN\n"),
            file + ":3: column 'units': 'N' is not allowed; expected 'N m' for channel force");
  EXPECT_EQ(refusal_of(file, "name\ttype\nangle\tJNTANG\n"),
            file + ":1: column 'units' is missing; expected the columns name, type, units");
  EXPECT_EQ(refusal_of(file, "name\ttype\tunits\nangle\tJNTANG\n"),
            file + ":2: 2 cells are not allowed: the header has 3");
  EXPECT_EQ(refusal_of(file, "name\ttype\tunits\tname\n"),
            file + ":1: column 'name' occurs twice; expected once");
}

TEST_F(DatasetErrors, NameARawUnitThatIsNotAllowed) {
  put_raw();
  EXPECT_EQ(refusal_of(kRawStem + "_channels.tsv",
                       "name\ttype\tunits\nq1\tMISC\tcount\nq2\tMISC\tcount\nf1\tMISC\tmV\nf2\tMISC\tV\n"),
            kRawStem + "_channels.tsv:4: column 'units': 'mV' is not allowed; expected 'V' for channel f1");
}

TEST_F(DatasetErrors, NameWhatTheRigDoesNotState) {
  put_raw();
  const std::string file = kRawStem + "_channels.json";
  std::filesystem::remove(root_ / file);
  EXPECT_EQ(refusal(), file + ": Rig.Axes is missing; expected a number");
  EXPECT_EQ(refusal_of(file, raw_json_with("\"Axes\": 2", "\"Axes\": 1")),
            file + ": Rig.Axes = 1 is not allowed; expected 2 for these channels");
  EXPECT_EQ(refusal_of(file, raw_json_with("[0.3, 0.35]", "[0.3]")),
            file + ": Rig.LinkLengths_m = [0.3] is not allowed; expected an array of 2 numbers");
  EXPECT_EQ(refusal_of(file, raw_json_with("\"EncoderSign\"", "\"Sign\"")),
            file + ": Rig.EncoderSign is missing; expected an array of 2 numbers");
  EXPECT_EQ(refusal_of(file, raw_json_with("[[4.0, 0.5], [0.0, 4.45]]", "[4.0, 4.45]")),
            file +
                ": Rig.ForceCalibration_N_per_V = [4.0,4.45] is not allowed; expected an array of 2 rows of "
                "2 numbers");
  EXPECT_EQ(refusal_of(file, raw_json_with("[1, -1]", "[1, 2]")),
            file + ": rig: EncoderSign: 2 is not allowed; expected +1 or -1");
  EXPECT_EQ(refusal_of(file, raw_json_with("\"angle_rad\": 0.2", "\"angle_rad\": \"?\"")),
            file + ": ShoulderInRobot.angle_rad = \"?\" is not allowed; expected a number");
}

TEST_F(DatasetErrors, NameABadForceSign) {
  put_one_axis();
  const std::string file = kOneAxisStem + "_channels.json";
  EXPECT_EQ(refusal_of(file, R"({"Rig": {"Axes": 1, "ForceSign": 2}})"),
            file + ": Rig.ForceSign = 2 is not allowed; expected 1 or -1");
}

TEST_F(DatasetErrors, NameAnEventThatIsNotAllowed) {
  put_one_axis();
  const std::string file = kOneAxisStem + "_events.tsv";
  EXPECT_EQ(refusal_of(file, "onset\ttrial\n0\t1\n"),
            file + ":1: column 'duration' is missing; expected the columns onset, duration");
  EXPECT_EQ(refusal_of(file, "onset\tduration\n-1\t0\n"),
            file + ":2: column 'onset': '-1' is not allowed; expected a number of at least 0");
  EXPECT_EQ(refusal_of(file, "onset\tduration\n0.001\t0.5\n"),
            file +
                ":2: column 'duration': '0.5' is not allowed; expected an end within the record's "
                "0.002 s, from the onset at 0.001 s");
  EXPECT_EQ(refusal_of(file, "onset\tduration\tvalid\n0\t0.001\tmaybe\n"),
            file + ":2: column 'valid': 'maybe' is not allowed; expected true, false or n/a");
  EXPECT_NE(refusal_of(file, "onset\tduration\ttrial_onset_s\n0\t0.001\t0\n")
                .find(":2: column 'trial_duration_s': 'n/a' is not allowed; expected both or none"),
            std::string::npos);
  EXPECT_NE(
      refusal_of(file, "onset\tduration\ttrial_onset_s\ttrial_duration_s\n0\t0.001\t0\t9\n")
          .find(":2: column 'trial_onset_s': '0' is not allowed; expected a trial that holds the onset"),
      std::string::npos);
  EXPECT_EQ(
      refusal_of(file, "onset\tduration\ttrial\n0\t0.001\t1.5\n"),
      file +
          ":2: column 'trial': '1.5' is not allowed; expected a whole number from -1000000000 to 1000000000");
  EXPECT_EQ(refusal_of(file, "onset\tduration\ttrial\n0\t0.001\t3\n0.001\t0.001\t3\n"),
            "events of sub-07 run 2: trial 3 occurs twice; expected once in a session");
  EXPECT_EQ(refusal_of(file, "onset\tduration\n"),
            file + ": has no row of trial_type perturbation; expected one");
}

TEST_F(DatasetErrors, NameAParticipantThatIsNotAllowed) {
  put_one_axis();
  EXPECT_EQ(refusal_of("participants.tsv", "participant_id\tage\nsub-07\told\n"),
            "participants.tsv:2: column 'age': 'old' is not allowed; expected a number or n/a");
  EXPECT_EQ(refusal_of("participants.tsv", "participant_id\nsub-01\n"),
            "participants.tsv: participant 'sub-07' is missing; expected a row, as the dataset has "
            "recordings of it");
}

/// Absent, unreachable and empty are three things: what cannot be reached is never left out.
TEST_F(DatasetErrors, NameALinkToNothingInPlaceOfAnyFile) {
  for (const std::string& name :
       {kRawStem + "_events.tsv", kRawStem + "_channels.json", std::string("participants.tsv"),
        std::string("dataset_description.json"), std::string("sub-02"), std::string("sub-01/ses-09"),
        std::string("sub-01/motion")}) {
    std::filesystem::remove_all(root_);
    put_raw();
    std::filesystem::remove(root_ / name);
    std::filesystem::create_symlink("gone", root_ / name);
    const std::string message = refusal();
    EXPECT_TRUE(message.starts_with(name)) << message;
    EXPECT_NE(message.find("cannot be reached: is a link to 'gone', which does not exist"), std::string::npos)
        << message;
  }
}

TEST_F(DatasetErrors, NameAFolderThatMayNotBeRead) {
  put_one_axis();
  put_raw();
  std::filesystem::permissions(folder_, std::filesystem::perms(0755));
  for (const char* name : {"sub-01", "sub-01/ses-02", "sub-01/ses-02/motion"}) {
    std::filesystem::permissions(root_ / name, std::filesystem::perms::none);
    const pid_t child = ::fork();
    if (child == 0) {
      if (::geteuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0)) ::_exit(2);
      const std::string message = refusal();
      ::_exit(message.starts_with(name) && message.find("Permission denied") != std::string::npos ? 0 : 1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0) << name;
    std::filesystem::permissions(root_ / name, std::filesystem::perms(0755));
  }
}

TEST_F(DatasetErrors, NameTextThatIsNotUtf8) {
  put_one_axis();
  EXPECT_EQ(
      refusal_of("participants.tsv", "participant_id\tsex\nsub-07\tM\xFC\x1B[2J\n"),
      "participants.tsv:2: 'sub-07\xEF\xBF\xBDM\xEF\xBF\xBD\xEF\xBF\xBD[2J' is not UTF-8 text; expected the "
      "file in UTF-8, as BIDS has it");
  std::filesystem::remove(root_ / "participants.tsv");
  EXPECT_NE(refusal_of(kOneAxisStem + "_events.tsv", "onset\tduration\treason\n0\t0.001\t\xE5\xB1\n")
                .find("_events.tsv:2: "),
            std::string::npos);
}

TEST_F(DatasetErrors, NameAPipeAndAHoleInPlaceOfRowsWithoutWaitingOrMemory) {
  put_one_axis();
  const auto rows = root_ / (kOneAxisStem + "_motion.tsv");
  std::filesystem::remove(rows);
  ASSERT_EQ(::mkfifo(rows.c_str(), 0600), 0);
  EXPECT_EQ(refusal(), kOneAxisStem + "_motion.tsv: cannot be read: not a regular file");
  std::filesystem::remove(rows);
  put_one_axis();
  std::filesystem::resize_file(rows, std::uintmax_t{30} << 30U);
  EXPECT_EQ(refusal(),
            kOneAxisStem +
                "_motion.tsv: a line of more than 4194304 bytes is not allowed; expected text with an "
                "end at each row");
}

TEST_F(DatasetErrors, NameANumberThatNothingCanBeCountedOnFrom) {
  put_one_axis();
  const std::string file = kOneAxisStem + "_events.tsv";
  for (const char* column : {"set", "trial"}) {
    EXPECT_EQ(
        refusal_of(file, std::string("onset\tduration\t") + column + "\n0\t0.001\t9223372036854775807\n"),
        file + ":2: column '" + column +
            "': '9223372036854775807' is not allowed; expected a whole number from -1000000000 to "
            "1000000000");
  }
}

}  // namespace
}  // namespace tonus::recording
