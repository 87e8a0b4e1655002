#pragma once

#include <Eigen/Core>

#include "rig_agent/control/servo_gains.hpp"
#include "services/mechanics/two_link_dynamics.hpp"

namespace tonus::control {

/// Whether a channel of the force sensor or an encoder has the wrong sign, by torque and motion.
///
/// The observer predicts the motion from the torque that was given and the force that was measured; what is
/// left, u (Servo::unexplained_torque()), shows what is wrong. If what channel k says has to be multiplied by
/// g_k to be true, then
///
///     u = sum over k of (1 - g_k) s_k,         s_k = J^T f_k,
///
/// f_k the force on the arm that it says. An encoder that counts backwards, and a model of the inertia that
/// is wrong, leave, with columns H_k,
///
///     u = sum over k of c_k (-H_k q"_k),       q" the accelerations that were predicted.
///
/// All pass the observer's filters and lose their slow mean (friction, an offset); both are fitted by least
/// squares over the last third of a second. 1 - g is 0 for a good channel and 2 for a reversed one; friction
/// takes up a small load whole, which looks like 1, but cannot turn one around. c is 2 for a reversed
/// encoder, 1 for one that stands still, and less than 1 for any inertia, however heavy. A channel or an
/// encoder is reversed where its number is above 1.5, and this explains more than half of u (an encoder: 0.8)
/// and more than the other explanation does; of a channel also after what a model that is off by a third may
/// leave. Small inertial torques say nothing of an encoder: those of sound rigs and soft subjects, up to half
/// of what friction can take up, look like a c of up to 1.9.
///
/// All methods are REALTIME.
class SignCheck {
 public:
  /// `period` in s.
  SignCheck(const ServoGains& gains, const JointFriction& friction, double period) noexcept;

  void begin_trial() noexcept { is_started_ = false; }

  /// What has been reversed for some time.
  struct Reversed {
    bool is_channel = false;
    bool is_encoder = false;
  };

  /// Takes u, s_1 and s_2 as columns, and -H_1 q"_1 and -H_2 q"_2, N m at the joints, all but u not filtered.
  [[nodiscard]] Reversed check(const Eigen::Vector2d& unexplained, const Eigen::Matrix2d& loads,
                               const Eigen::Matrix2d& accelerations) noexcept;

 private:
  using Columns = Eigen::Matrix<double, 2, 4>;  // channels, accelerations

  struct Fit {
    Eigen::Vector2d excess;  // 1 - g, or c
    Eigen::Vector2d own;     // (N m)^2 of each column, beside what it shares with the other
    double explained = 0.0;  // of u, (N m)^2
  };

  void start(const Eigen::Vector2d& unexplained, const Columns& said) noexcept;
  void filter(const Eigen::Vector2d& unexplained, const Columns& said) noexcept;
  /// Of the two columns from `first` on, with a ridge: what is silent is taken for good.
  [[nodiscard]] Fit fit(int first) const noexcept;
  /// Whether the channels explain what is left, better than the motion does.
  [[nodiscard]] bool do_channels_explain(const Fit& channels, const Fit& motion) const noexcept;
  /// Whether the motion explains what is left, better than the channels do.
  [[nodiscard]] bool does_motion_explain(const Fit& channels, const Fit& motion) const noexcept;
  /// The cycles in which each column, of at least `least` N m rms, was reversed, one after the other; true
  /// where they are enough.
  [[nodiscard]] bool lasts(const Fit& fit, bool is_explained, double least,
                           Eigen::Vector2i& cycles) const noexcept;

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
  Eigen::Vector2i channel_cycles_ = Eigen::Vector2i::Zero();
  Eigen::Vector2i encoder_cycles_ = Eigen::Vector2i::Zero();
};

}  // namespace tonus::control
