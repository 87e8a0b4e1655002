#pragma once

#include <Eigen/Core>

#include "rig_agent/control/observer_response.hpp"
#include "rig_agent/control/servo_gains.hpp"
#include "rig_agent/control/unexplained_window.hpp"
#include "services/mechanics/two_link_dynamics.hpp"

namespace tonus::control {

/// Whether a channel of the force sensor has the wrong sign, by torque and motion.
///
/// The observer predicts the motion from the torque that was given and the force that was measured; what is
/// left, u (Servo::unexplained_torque()), shows what is wrong. If what channel k says has to be multiplied by
/// g_k to be true, then
///
///     u = sum over k of (1 - g_k) s_k,         s_k = J^T f_k,
///
/// f_k the force on the arm that it says. A model of the inertia that is wrong leaves, with columns H_k,
///
///     u = sum over k of c_k (-H_k q"_k),       q" the accelerations that were predicted.
///
/// All pass the observer's filters and lose their slow mean (friction, an offset); both are fitted by least
/// squares over the last third of a second. 1 - g is 0 for a good channel and 2 for a reversed one; friction
/// takes up a small load whole, which looks like 1, but cannot turn one around. A channel is reversed where
/// 1 - g is above 1.5, and this explains more than half of u, after what a model that is off by a third may
/// leave, and more than a wrong model does. Encoders are not judged so: one that stands still looks like such
/// a model.
///
/// All methods are REALTIME.
class ForceSignCheck {
 public:
  /// `period` in s.
  ForceSignCheck(const ServoGains& gains, const JointFriction& friction, double period) noexcept;

  void begin_trial() noexcept { is_started_ = false; }

  /// Takes u, s_1 and s_2 as columns, and -H_1 q"_1 and -H_2 q"_2, N m at the joints, all but u not filtered.
  /// True where a channel has been reversed for some time.
  [[nodiscard]] bool finds_reversed(const Eigen::Vector2d& unexplained, const Eigen::Matrix2d& loads,
                                    const Eigen::Matrix2d& accelerations) noexcept;

 private:
  using Columns = Eigen::Matrix<double, 2, 4>;  // channels, accelerations

  struct Fit {
    Eigen::Vector2d excess;  // 1 - g, or c
    Eigen::Vector2d own;     // (N m)^2 of each column, beside what it shares with the other
    double explained = 0.0;  // of u, (N m)^2
  };

  void start(const Eigen::Vector2d& unexplained, const Columns& said) noexcept;
  /// Of the two columns from `first` on, with a ridge: what is silent is taken for good.
  [[nodiscard]] Fit fit(int first) const noexcept;
  /// Whether the channels explain what is left, better than a wrong model does.
  [[nodiscard]] bool explains_most(const Fit& channels) const noexcept;

  const double taken_up_;  // N m rms, of an s that friction could take up
  const int cycles_needed_;

  bool is_started_ = false;
  ObserverResponse<4> response_;
  UnexplainedWindow<4> window_;
  Eigen::Vector2i cycles_reversed_ = Eigen::Vector2i::Zero();
};

}  // namespace tonus::control
