#pragma once

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <unistd.h>

namespace tonus::recording::testing {

/// A folder of its own for each test, removed at its end, and short ways to fill it.
class DatasetFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "tonus-recording-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    root_ = folder_ / "dataset";
  }

  void TearDown() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  /// Writes a file below the dataset's root.
  void put(const std::string& name, const std::string& text) {
    const std::filesystem::path path = root_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
  }

  static std::string content(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
  }

  /// A complete one-axis dataset of two rows.
  void put_one_axis() {
    put("dataset_description.json", R"({"Name": "made up", "BIDSVersion": "1.9.0"})");
    put(kOneAxisStem + "_motion.json", R"({"TaskName": "hold", "SamplingFrequency": 1000})");
    put(kOneAxisStem + "_channels.tsv",
        "name\tcomponent\ttype\ttracked_point\tunits\n"
        "angle\tn/a\tJNTANG\tankle\trad\n"
        "torque\tn/a\tMISC\tankle\tN m\n");
    put(kOneAxisStem + "_motion.tsv", "0.5\t-2\n0.25\t3e-1\n");
  }

  /// A complete raw two-axis dataset of three rows.
  void put_raw() {
    put("dataset_description.json", R"({"Name": "made up", "BIDSVersion": "1.9.0"})");
    put(kRawStem + "_motion.json", R"({"TaskName": "unloaded", "SamplingFrequency": 200})");
    put(kRawStem + "_channels.tsv",
        "name\ttype\tunits\nq1\tMISC\tcount\nq2\tMISC\tcount\nf1\tMISC\tV\nf2\tMISC\tV\n");
    put(kRawStem + "_channels.json", kRawJson);
    put(kRawStem + "_motion.tsv", "0\t2000\t0.5\t0.25\n1\t2001\t0.5\t0.25\n2\t2002\t1.5\t-1.25\n");
  }

  /// kRawJson with one text in it replaced.
  static std::string raw_json_with(const std::string& from, const std::string& to) {
    std::string text = kRawJson;
    text.replace(text.find(from), from.size(), to);
    return text;
  }

  inline static const std::string kOneAxisStem = "sub-07/motion/sub-07_task-hold_tracksys-servo_run-02";
  inline static const std::string kRawStem =
      "sub-01/ses-02/motion/sub-01_ses-02_task-unloaded_tracksys-manipulandum_acq-left_run-03";
  inline static const std::string kRawJson = R"({
    "Rig": { "Axes": 2, "LinkLengths_m": [0.3, 0.35], "EncoderCountsPerRevolution": [8000, 4000],
             "EncoderZero_count": [0, 1000], "EncoderSign": [1, -1],
             "ForceCalibration_N_per_V": [[4.0, 0.5], [0.0, 4.45]], "ForceOffset_V": [0.5, 0.25],
             "ForceSensorAngle_rad": 0.1, "HandleMass_kg": 0.2 },
    "ShoulderInRobot": { "x_m": 0.05, "y_m": -0.10, "angle_rad": 0.2 },
    "Posture": { "name": "left", "x_m": -0.295, "y_m": 0.38 } })";

  std::filesystem::path folder_;
  std::filesystem::path root_;
};

}  // namespace tonus::recording::testing
