#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>

#include "services/core/result.hpp"
#include "services/mechanics/two_link.hpp"

namespace tonus {

/// How a rig's channels map to the endpoint.
enum class RigKind : std::uint8_t {
  kTwoLink,  ///< Two encoders on the joints of a two-link manipulandum; the force sensor turns with the outer
             ///< link.
  kCartesian,  ///< Channels are already endpoint displacement and force in the shoulder frame, times a scale.
  kOneAxis,  ///< One displacement (m or rad) and one force (N) or torque (N m); the second channels are zero.
};

/// One row of raw measurement as the hardware gave it. Counts are held as double because a replayed recording
/// may hold converted displacements instead (one "count" is then 1 m or 1 rad); an encoder gives whole
/// numbers.
struct RawSample {
  std::int64_t acquisition_ns = 0;        ///< Rig's monotonic clock, ns.
  std::array<double, 2> encoder_count{};  ///< Inner and outer joint.
  std::array<double, 2> force_V{};        ///< Both axes of the force sensor, in the sensor's frame.
};

/// Position of the subject's shoulder frame S in the robot's base frame R: p_R = origin + Rot(angle) p_S.
struct ShoulderPose {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< m, in R.
  double angle = 0.0;                                ///< rad, from R's x axis to S's x axis.
};

/// What turns raw counts and volts into SI: the measured constants of a rig. Version 1 of the conversion.
struct RigGeometry {
  RigKind kind = RigKind::kTwoLink;
  TwoLink links{0.30, 0.35};
  std::array<double, 2> encoder_zero{};          ///< Count at joint angle 0 (or displacement 0).
  std::array<double, 2> encoder_sign{1.0, 1.0};  ///< +1 or -1.
  std::array<double, 2> counts_per_unit{1273.2395447351628,
                                        1273.2395447351628};               ///< Counts per rad, or per m.
  Eigen::Matrix2d force_calibration = 4.45 * Eigen::Matrix2d::Identity();  ///< N (or N m) per V.
  Eigen::Vector2d force_offset_V = Eigen::Vector2d::Zero();                ///< V at no force.
  double force_sensor_angle = 0.0;   ///< rad, sensor's x axis from the outer link.
  double handle_mass = 0.0;          ///< kg on the hand's side of the flexure.
  double force_saturation_V = 10.0;  ///< |V| at which the sensor or the converter is clipped.
};

/// A converted row: endpoint position and the force of the handle on the arm, both in S (one-axis rigs: first
/// component only, in the rig's own units).
struct EndpointSample {
  std::int64_t acquisition_ns = 0;
  Eigen::Vector2d p_SE = Eigen::Vector2d::Zero();  ///< m, endpoint from the shoulder.
  Eigen::Vector2d f_S = Eigen::Vector2d::Zero();   ///< N, on the arm.
};

/// Joint angles (rad) or displacements of a raw row: sign (count - zero) / counts_per_unit.
[[nodiscard]] Eigen::Vector2d joint_coordinates(const RigGeometry& rig, const RawSample& raw);

/// Counts to joint angles to endpoint in R to S; volts to N in the sensor's frame, turned through
/// q1 + q2 + force_sensor_angle into R, and into S (method, section 2). Pure; allocates nothing.
[[nodiscard]] EndpointSample convert(const RigGeometry& rig, const ShoulderPose& shoulder,
                                     const RawSample& raw);

/// Refuses a geometry that cannot be converted with: lengths and scales not positive, a singular calibration.
[[nodiscard]] Result<void> validate(const RigGeometry& rig);

}  // namespace tonus
