#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rig_agent/drivers/replay.hpp"
#include "services/core/result.hpp"
#include "services/recording/recording.hpp"

#include <idl/trial.h>

namespace tonus::rig {

/// The trials of a dataset, for the replay driver: one segment for each whole record and one for each of its
/// perturbations, and what each one's TrialProgram says of posture and shoulder.
class RecordedTrials {
 public:
  /// All records must be of one rig, one sampling rate and the same auxiliary channels. kInvalidArgument
  /// names the two that differ.
  [[nodiscard]] static Result<RecordedTrials> create(std::vector<recording::Recording> records);

  /// The rows and segments, handed out once.
  [[nodiscard]] drivers::Recording take_recording() { return std::move(recording_); }

  /// Segment that a program names, and in the program the place of the hand and the shoulder as recorded.
  /// kNotFound where the dataset has no such record or event.
  [[nodiscard]] Result<std::uint32_t> prepare(v1::TrialProgram& program) const;

  [[nodiscard]] double rate() const { return rate_; }
  /// Where the handle is in the first row, m in R; zero where the channels are not joint angles.
  [[nodiscard]] const Eigen::Vector2d& home() const { return home_; }
  [[nodiscard]] const std::string& displacement_unit() const { return displacement_unit_; }
  [[nodiscard]] const std::string& force_unit() const { return force_unit_; }

 private:
  struct Record {
    std::string name;
    ShoulderPose shoulder;
    Eigen::Vector2d posture = Eigen::Vector2d::Zero();
    std::uint32_t whole_segment = 0;  // its events follow
    std::uint32_t events = 0;
  };

  void add(const recording::Recording& source);

  drivers::Recording recording_;
  std::vector<Record> records_;
  double rate_ = 0.0;
  Eigen::Vector2d home_ = Eigen::Vector2d::Zero();
  std::string displacement_unit_;
  std::string force_unit_;
};

}  // namespace tonus::rig
