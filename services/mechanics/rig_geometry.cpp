#include "services/mechanics/rig_geometry.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <spdlog/fmt/fmt.h>

namespace tonus {

Eigen::Vector2d joint_coordinates(const RigGeometry& rig, const RawSample& raw) {
  Eigen::Vector2d q;
  for (std::size_t i = 0; i < 2; ++i) {
    q[static_cast<Eigen::Index>(i)] =
        rig.encoder_sign[i] * (raw.encoder_count[i] - rig.encoder_zero[i]) / rig.counts_per_unit[i];
  }
  return q;
}

EndpointSample convert(const RigGeometry& rig, const ShoulderPose& shoulder, const RawSample& raw) {
  const Eigen::Vector2d q = joint_coordinates(rig, raw);
  const Eigen::Vector2d f_sensor =
      rig.force_calibration * (Eigen::Vector2d(raw.force_V[0], raw.force_V[1]) - rig.force_offset_V);
  if (rig.kind != RigKind::kTwoLink) return {raw.acquisition_ns, q, f_sensor};

  const Eigen::Rotation2Dd shoulder_to_robot(shoulder.angle);
  const Eigen::Rotation2Dd sensor_to_robot(q[0] + q[1] + rig.force_sensor_angle);
  return {raw.acquisition_ns, shoulder_to_robot.inverse() * (rig.links.endpoint(q) - shoulder.origin),
          shoulder_to_robot.inverse() * (sensor_to_robot * f_sensor)};
}

Result<void> validate(const RigGeometry& rig) {
  const auto refuse = [](const char* what, double value, const char* allowed) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("rig: {}: {} is not allowed; expected {}", what, value, allowed));
  };
  if (rig.kind == RigKind::kTwoLink) {
    if (!(rig.links.l1 > 0.0)) return refuse("LinkLengths_m[0]", rig.links.l1, "more than 0 m");
    if (!(rig.links.l2 > 0.0)) return refuse("LinkLengths_m[1]", rig.links.l2, "more than 0 m");
  }
  for (std::size_t i = 0; i < 2; ++i) {
    if (!(rig.counts_per_unit[i] > 0.0))
      return refuse("counts per unit", rig.counts_per_unit[i], "more than 0");
    if (std::abs(rig.encoder_sign[i]) != 1.0) return refuse("EncoderSign", rig.encoder_sign[i], "+1 or -1");
  }
  const double determinant = rig.force_calibration.determinant();
  if (!std::isfinite(determinant) || determinant == 0.0) {
    return refuse("determinant of ForceCalibration_N_per_V", determinant, "a regular matrix");
  }
  if (!(rig.handle_mass >= 0.0)) return refuse("HandleMass_kg", rig.handle_mass, "0 kg or more");
  return {};
}

}  // namespace tonus
