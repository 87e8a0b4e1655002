#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include <idl/trial.h>

namespace tonus::contract {

/// Where a trial is: the posture's name, its place in the plan, and its position (m in R).
struct TrialPlace {
  std::string posture;
  std::uint32_t posture_index = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
};

/// A program in the first set of a place that replays no recording: what every maker of programs begins with.
[[nodiscard]] v1::TrialProgram new_program(v1::TrialKind kind, const TrialPlace& place);

}  // namespace tonus::contract
