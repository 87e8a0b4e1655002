#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "analysis_service/identification/measured_trial.hpp"
#include "analysis_service/identification/trial_assembler.hpp"

/// Trials whose every number is a closed form: the hand follows a given way, and the force on the arm is
/// F = M X" + B X' + K X + bias with the matrices below.
namespace tonus::identification::testing {

inline constexpr double kRate = 200.0;  // Hz

struct TrueArm {
  Eigen::Matrix2d M{{1.6, 0.25}, {0.25, 1.1}};      // kg
  Eigen::Matrix2d B{{14.0, 3.0}, {2.5, 10.0}};      // N s/m
  Eigen::Matrix2d K{{320.0, 60.0}, {50.0, 210.0}};  // N/m
};

/// The published manipulandum: two links of 0.30 and 0.35 m, a sensor that turns with the outer one.
[[nodiscard]] RigGeometry made_up_rig();

/// Inverse of tonus::convert, without quantisation.
[[nodiscard]] RawSample raw_of(const RigGeometry& rig, const ShoulderPose& shoulder,
                               const Eigen::Vector2d& p_SE, const Eigen::Vector2d& f_S);

/// What to make, and what to spoil: additions to the way (m) and the force (N) as functions of the time from
/// the onset (s) and the row's phase.
struct Recipe {
  std::uint32_t attempt = 1;
  double direction_deg = 0.0;
  double amplitude = 0.005;
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();
  std::int32_t set = 1;
  std::uint32_t posture_index = 0;
  std::uint64_t first_sequence = 1000;
  std::uint64_t epoch = 7;
  RigGeometry rig = made_up_rig();
  std::function<Eigen::Vector2d(double, Phase)> added_way;
  std::function<Eigen::Vector2d(double, Phase)> added_force;
};

[[nodiscard]] Id made_up_session();
[[nodiscard]] Id made_up_rig_id();

/// Centring 0.2 s, waiting 1 s, with a bias its ramp of 0.5 s and hold of 1 s, perturbation of 1.75 s with a
/// minimum-jerk rise in 0.2 s, way back of 0.3 s.
[[nodiscard]] MeasuredTrial made_up_trial(const Recipe& recipe);

/// The trial in blocks of so many rows, which stay valid as long as the trial.
[[nodiscard]] std::vector<RowBlock> blocks_of(const MeasuredTrial& trial, std::size_t rows_a_block);

/// True if both have the same rows, bit for bit.
[[nodiscard]] bool same_rows(const std::vector<Row>& a, const std::vector<Row>& b);

/// 16 perturbations, every 45 deg in two sets, attempts 1 to 16.
[[nodiscard]] std::vector<MeasuredTrial> made_up_condition();

}  // namespace tonus::identification::testing
