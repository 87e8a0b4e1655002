#pragma once

#include <Eigen/Core>

#include "rig_agent/control/servo_gains.hpp"
#include "services/mechanics/two_link_dynamics.hpp"

namespace tonus::control {

/// Whether force sensor and encoders say what torque asks for.
///
/// The observer predicts the motion from the torque that was given and the force that was measured; what is
/// left, u (Servo::unexplained_torque()), shows a sensor that is wrong. If what channel k of the force sensor
/// says, or the acceleration of joint k that was predicted, has to be multiplied by g_k to be true, then
///
///     u = sum over k of (1 - g_k) s_k,
///
/// - for a channel, s_k = J^T f_k: the load of the force f_k on the arm that it says;
/// - for an encoder, s_k = -H_k q"_k, H_k the column of the mass matrix.
///
/// All pass the observer's filters and lose their slow mean (friction, an offset); 1 - g of the two channels,
/// and of the two encoders, is the least-squares solution over the last third of a second: 0 for a good
/// sensor, 1 for one that stands still or says what nobody feels, 2 for a reversed one. It counts once what
/// it explains of u is more than half of u, after what a model that is off by a third may leave. Friction
/// that the model does not know takes up a small torque whole, which looks like 1, but cannot turn one
/// around: the smaller s, the more is asked of 1 - g.
///
/// All methods are REALTIME.
class SensorTest {
 public:
  struct Finding {
    bool is_force_wrong = false;
    bool is_encoder_wrong = false;
  };

  /// `period` in s.
  SensorTest(const ServoGains& gains, const JointFriction& friction, double period) noexcept;

  void begin_trial() noexcept { is_started_ = false; }

  /// Takes u, and s of the channels and of the encoders as columns, N m at the joints, not filtered. What has
  /// been wrong for some time is found.
  [[nodiscard]] Finding check(const Eigen::Vector2d& unexplained, const Eigen::Matrix2d& loads,
                              const Eigen::Matrix2d& accelerations) noexcept;

 private:
  using Columns = Eigen::Matrix<double, 2, 4>;  // channels, encoders

  void start(const Eigen::Vector2d& unexplained, const Columns& said) noexcept;
  void filter(const Eigen::Vector2d& unexplained, const Columns& said) noexcept;
  [[nodiscard]] bool is_wrong(int sensor) const noexcept;

  const double observer_share_;  // Shares of the new value in one cycle.
  const double unexplained_share_;
  const double mean_share_;
  const double window_share_;
  const double taken_up_;  // N m rms, of an s that friction could take up
  const int cycles_needed_;

  bool is_started_ = false;
  Columns filtered_once_ = Columns::Zero();
  Columns filtered_twice_ = Columns::Zero();
  Columns said_ = Columns::Zero();
  Columns mean_said_ = Columns::Zero();
  Eigen::Vector2d mean_unexplained_ = Eigen::Vector2d::Zero();
  Eigen::Matrix4d products_ = Eigen::Matrix4d::Zero();   // of s, (N m)^2
  Eigen::Vector4d responses_ = Eigen::Vector4d::Zero();  // of s with u, (N m)^2
  double power_ = 0.0;                                   // of u, (N m)^2
  Eigen::Vector4i cycles_wrong_ = Eigen::Vector4i::Zero();
};

}  // namespace tonus::control
