#pragma once

#include <Eigen/Core>

namespace tonus::control {

/// What can be wrong with a rig, as columns of torques (N m at the two joints) that explain
/// Servo::unexplained_torque() u, each times a number that is 0 for a rig that is as the law knows it.
///
/// With H the inertia, tau the torques that were given, f_k the force on the arm (N) that channel k says, and
/// q" the accelerations that were predicted,
///
///     H q"_true = g tau - sum over k of h_k J^T f_k - friction,        q"_seen = +-q"_true
///     u = H (q"_seen - q")
///       = sum over k of  a_k (-tau_k e_k)       a = 1 - g, g the motor's true torque over the one asked for
///                      + b_k J^T f_k            b = 1 - h, h the channel's true force over the one it says
///                      + c_k (-H_k q"_k)        c = 2 for an encoder that counts backwards; e / (1 + e) for
///                                               an inertia that is larger by the share e, and so below 1
///                      + d_k (-sign(q'_k) e_k)  d = N m of Coulomb friction more than was compensated
struct UnexplainedCauses {
  static constexpr int kTorques = 0;  ///< First of two columns each.
  static constexpr int kChannels = 2;
  static constexpr int kAccelerations = 4;
  static constexpr int kFriction = 6;
  static constexpr int kCount = 8;

  using Columns = Eigen::Matrix<double, 2, kCount>;
  using Numbers = Eigen::Matrix<double, kCount, 1>;

  /// What a motor may give of what it is asked for, and still be one: 0.2 to 1.5 times.
  static constexpr double kWeakestMotor = 0.8;
  static constexpr double kStrongestMotor = -0.5;
};

}  // namespace tonus::control
