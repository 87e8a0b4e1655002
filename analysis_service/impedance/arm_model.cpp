#include "analysis_service/impedance/arm_model.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>
#include <spdlog/fmt/fmt.h>

namespace tonus::impedance {
namespace {

Result<Eigen::Matrix2d> jacobian_at(const ArmModel& arm, const Eigen::Vector2d& position) {
  const TwoLink links = arm.links();
  if (!links.reaches(position)) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "posture: distance from the shoulder: {:.4g} m is not allowed; expected {:.4g} to {:.4g} m",
            position.norm(), std::abs(links.l1 - links.l2), links.l1 + links.l2));
  }
  return links.jacobian(links.angles_at(position));
}

/// [v1^2, v1 v2, v2^2].
Eigen::Vector3d products(const Eigen::Vector2d& v) { return {v[0] * v[0], v[0] * v[1], v[1] * v[1]}; }

}  // namespace

double radius_from_mass(double mass, double length, double density) {
  return std::sqrt(mass / (density * std::numbers::pi * length));
}

double radius_from_circumference(double circumference) { return circumference / (2.0 * std::numbers::pi); }

Eigen::Matrix2d JointImpedance::matrix() const {
  Eigen::Matrix2d joint;
  joint << shoulder + two_joint, two_joint, two_joint, elbow + two_joint;
  return joint;
}

Eigen::Matrix2d ArmModel::inertia(const Eigen::Vector2d& angles) const {
  const double l1 = upper_arm.length;
  const double coupling = 0.5 * forearm.mass * l1 * forearm.length * std::cos(angles[1]);
  const double forearm_end = forearm.inertia_about_end();
  Eigen::Matrix2d I;
  I(0, 0) = upper_arm.inertia_about_end() + forearm.mass * l1 * l1 + forearm_end + 2.0 * coupling;
  I(0, 1) = I(1, 0) = forearm_end + coupling;
  I(1, 1) = forearm_end;
  return I;
}

Eigen::Vector2d ArmModel::coriolis_torque(const Eigen::Vector2d& angles, const Eigen::Vector2d& rates) const {
  const double h = 0.5 * forearm.mass * upper_arm.length * forearm.length * std::sin(angles[1]);
  return {-h * (2.0 * rates[0] * rates[1] + rates[1] * rates[1]), h * rates[0] * rates[0]};
}

Eigen::Matrix<double, 2, 3> ArmModel::coriolis_matrix(const Eigen::Vector2d& angles,
                                                      bool has_jacobian_rate) const {
  const TwoLink arm = links();
  const Eigen::Matrix2d J = arm.jacobian(angles);
  const Eigen::Matrix2d J_inverse = J.inverse();
  const auto force_at = [&](const Eigen::Vector2d& velocity) -> Eigen::Vector2d {
    const Eigen::Vector2d rates = J_inverse * velocity;
    Eigen::Vector2d torque = coriolis_torque(angles, rates);
    if (has_jacobian_rate)
      torque -= inertia(angles) * (J_inverse * (arm.jacobian_rate(angles, rates) * rates));
    return J_inverse.transpose() * torque;
  };
  // A quadratic form in (v1, v2) is known from its values at (1,0), (0,1) and (1,1).
  const Eigen::Vector2d along_x = force_at(Eigen::Vector2d::UnitX());
  const Eigen::Vector2d along_y = force_at(Eigen::Vector2d::UnitY());
  Eigen::Matrix<double, 2, 3> B_C;
  B_C << along_x, force_at(Eigen::Vector2d::Ones()) - along_x - along_y, along_y;
  return B_C;
}

Eigen::Matrix2d to_endpoint(const Eigen::Matrix2d& joint, const Eigen::Matrix2d& jacobian) {
  const Eigen::Matrix2d inverse = jacobian.inverse();
  return inverse.transpose() * joint * inverse;
}

Eigen::Matrix2d to_joints(const Eigen::Matrix2d& endpoint, const Eigen::Matrix2d& jacobian) {
  return jacobian.transpose() * endpoint * jacobian;
}

Result<CartesianImpedance> forward_model(const ArmModel& arm, const JointImpedance& stiffness,
                                         const JointImpedance& damping, const Eigen::Vector2d& position) {
  const auto J = jacobian_at(arm, position);
  if (!J) return J.error();
  return CartesianImpedance{to_endpoint(arm.inertia(arm.links().angles_at(position)), *J),
                            to_endpoint(damping.matrix(), *J), to_endpoint(stiffness.matrix(), *J)};
}

Result<CoriolisCheck> coriolis_check(const ArmModel& arm, const Eigen::Vector2d& position,
                                     const Eigen::Matrix2d& B, double speed) {
  if (const auto J = jacobian_at(arm, position); !J) return J.error();
  const Eigen::Matrix<double, 2, 3> B_C = arm.coriolis_matrix(arm.links().angles_at(position));
  constexpr int kDirections = 360;
  CoriolisCheck check;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kDirections;
    const Eigen::Vector2d velocity = speed * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    check.coriolis_force = std::max(check.coriolis_force, (B_C * products(velocity)).norm());
    check.damping_force = std::max(check.damping_force, (B * velocity).norm());
  }
  check.share = check.damping_force > 0.0 ? check.coriolis_force / check.damping_force
                                          : std::numeric_limits<double>::infinity();
  return check;
}

}  // namespace tonus::impedance
