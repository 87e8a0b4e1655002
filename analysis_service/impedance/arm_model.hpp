#pragma once

#include <Eigen/Core>

#include "services/core/result.hpp"
#include "services/mechanics/two_link.hpp"

namespace tonus::impedance {

/// Density of a limb, kg/m3, where a radius is to be had from a mass (method, section 6).
inline constexpr double kLimbDensity = 1050.0;

/// A limb segment as a uniform cylinder, turning about its own proximal end in the horizontal plane.
struct Cylinder {
  double mass = 0.0;    ///< kg.
  double length = 0.0;  ///< m.
  double radius = 0.0;  ///< m.

  /// About the end, across the axis: m (l^2/3 + r^2/4), kg m2.
  [[nodiscard]] double inertia_about_end() const { return mass * inertia_per_mass(); }
  [[nodiscard]] double inertia_per_mass() const { return length * length / 3.0 + radius * radius / 4.0; }
};

/// Radius (m) of a cylinder of this mass (kg), length (m) and density (kg/m3).
[[nodiscard]] double radius_from_mass(double mass, double length, double density = kLimbDensity);

/// Radius (m) from a circumference (m).
[[nodiscard]] double radius_from_circumference(double circumference);

/// Stiffness (N m/rad) or damping (N m s/rad) of the three muscle groups of Fig. 1.
struct JointImpedance {
  double shoulder = 0.0;
  double elbow = 0.0;
  double two_joint = 0.0;

  /// [[s + d, d], [d, e + d]] of (21).
  [[nodiscard]] Eigen::Matrix2d matrix() const;
};

/// The Cartesian matrices of (3) at a posture, in S: kg, N s/m, N/m.
struct CartesianImpedance {
  Eigen::Matrix2d M = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d B = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d K = Eigen::Matrix2d::Zero();
};

/// Two-cylinder arm in the horizontal plane: joint angles t = (shoulder from +x, elbow relative), torques N
/// m.
struct ArmModel {
  Cylinder upper_arm;
  Cylinder forearm;  ///< With the hand.

  [[nodiscard]] TwoLink links() const { return {upper_arm.length, forearm.length}; }

  /// I(t) of (22), kg m2, symmetric and positive definite.
  [[nodiscard]] Eigen::Matrix2d inertia(const Eigen::Vector2d& angles) const;

  /// C(t, t') of (22), N m, for joint rates in rad/s.
  [[nodiscard]] Eigen::Vector2d coriolis_torque(const Eigen::Vector2d& angles,
                                                const Eigen::Vector2d& rates) const;

  /// B_C(t) of (12), (14): endpoint force J^-T C = B_C [x1'^2, x1' x2', x2'^2]', N s2/m2. With
  /// `has_jacobian_rate` the term -J^-T I J^-1 J' t' that (28) neglects is included: the exact force at X" =
  /// 0.
  [[nodiscard]] Eigen::Matrix<double, 2, 3> coriolis_matrix(const Eigen::Vector2d& angles,
                                                            bool has_jacobian_rate = false) const;
};

/// J^-T R J^-1 (31): a joint matrix (N m/rad ...) to the endpoint (N/m ...).
[[nodiscard]] Eigen::Matrix2d to_endpoint(const Eigen::Matrix2d& joint, const Eigen::Matrix2d& jacobian);

/// J^T Z J (17): an endpoint matrix to the joints.
[[nodiscard]] Eigen::Matrix2d to_joints(const Eigen::Matrix2d& endpoint, const Eigen::Matrix2d& jacobian);

/// Forward model (21)-(31) at the posture where the hand is at `position` (m, in S).
/// Error kInvalidArgument: the position is out of the arm's reach.
[[nodiscard]] Result<CartesianImpedance> forward_model(const ArmModel& arm, const JointImpedance& stiffness,
                                                       const JointImpedance& damping,
                                                       const Eigen::Vector2d& position);

/// Coriolis and centrifugal endpoint force against the damping force, at one speed in any direction.
struct CoriolisCheck {
  double coriolis_force = 0.0;  ///< N, largest over directions of |B_C v v'|.
  double damping_force = 0.0;   ///< N, largest over directions of |B v|.
  double share = 0.0;           ///< coriolis_force / damping_force; infinite without damping.
};

/// Magnitude check of method section 4 for a speed in m/s and an identified B (N s/m). Published: a share of
/// one to two orders of magnitude below 1 at 0.8 m/s.
[[nodiscard]] Result<CoriolisCheck> coriolis_check(const ArmModel& arm, const Eigen::Vector2d& position,
                                                   const Eigen::Matrix2d& B, double speed);

}  // namespace tonus::impedance
