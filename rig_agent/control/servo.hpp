#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "rig_agent/control/damping_watch.hpp"
#include "rig_agent/control/servo_gains.hpp"
#include "services/mechanics/two_link_dynamics.hpp"

namespace tonus::control {

/// Corner of the low-pass of Servo::unexplained_torque(), rad/s.
inline constexpr double kUnexplainedFilter = 15.0;

/// What the servo is to do in a cycle.
enum class ServoMode : std::uint8_t {
  kFloat,  ///< Exert `force` on the hand and damp; the hand decides where it is.
  kLead,   ///< Follow position, velocity and acceleration, well damped.
  kRing,   ///< Go to `position` underdamped: the perturbation.
  kSafe,   ///< Damp the joints until at rest, then no torque: safe_torque().
};

/// Wish for one cycle, in the robot's base frame R, SI. `force` acts on the arm, beside whatever the mode
/// does.
struct Reference {
  ServoMode mode = ServoMode::kFloat;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
  Eigen::Vector2d acceleration = Eigen::Vector2d::Zero();
  Eigen::Vector2d force = Eigen::Vector2d::Zero();
  bool corrects_force = false;  ///< kFloat: integrate the measured force's error away.
  double frequency = 0.0;       ///< kRing: natural frequency of the servo, rad/s.
};

/// What is known of the handle in a cycle, in R: measured where the sensors give it, by the observer for
/// velocity.
struct HandleEstimate {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m, observer.
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< m/s, observer.
  Eigen::Vector2d measured = Eigen::Vector2d::Zero();  ///< m, from the encoders alone.
  Eigen::Vector2d force = Eigen::Vector2d::Zero();     ///< N, on the arm.
};

/// Cartesian-error inverse-dynamics control of the manipulandum:
///
///     tau = H J^-1 (a - J' q') + c(q, q') + friction(q') + J^T (f + trim)
///
/// which for a regular J is J^T Lambda (a - J' q') + ..., Lambda = J^-T H J^-1 the mass matrix at the handle,
/// and
///
///     a = x"_r + 2 zeta wn (x'_r - x') + wn^2 (x_r - x)     (kLead, kRing)
///     a = -d x'                                              (kFloat)
///
/// so that the servo alone behaves alike in every direction and place. The force of the arm is not fed back
/// into a: the handle stays a mass-spring-damper with which the arm shares its motion, as on the published
/// apparatus, and no delay in the force path can make a stiff arm unstable.
///
/// Position and velocity come from an observer, because the difference of two encoder readings one period
/// apart is 0 or 0.8 rad/s. It predicts with a + Lambda^-1 (f + trim - f_measured), and corrects by the
/// encoders with both poles at `observer_frequency`.
///
/// All methods are REALTIME.
class Servo {
 public:
  Servo(const TwoLink& links, const ManipulandumModel& model, const ServoGains& gains, double period);

  /// Takes joint angles (rad) and the force on the arm (N, in R) of this cycle. The first call starts the
  /// observer at rest at the measured position.
  const HandleEstimate& observe(const Eigen::Vector2d& joint_angles, const Eigen::Vector2d& force) noexcept;

  /// Joint torques, N m, for the reference and the last observation.
  [[nodiscard]] Eigen::Vector2d torque(const Reference& reference) noexcept;

  /// Torque of the safe state: -damping q', each joint at most `limit`, until the joints are at rest, or
  /// until it was found to drive what it is to damp (DampingWatch); then zero until torque() is called again.
  /// Rest is only found in cycles that were observed: restart() begins its 0.1 s anew.
  [[nodiscard]] Eigen::Vector2d safe_torque(double damping, double limit) noexcept;

  /// Forgets the observer's state: the next observation starts it anew.
  void restart() noexcept;

  /// True in the safe state once the joints have been at rest for 0.1 s: from then on no torque is given.
  [[nodiscard]] bool is_released() const noexcept { return is_released_; }

  [[nodiscard]] const HandleEstimate& estimate() const noexcept { return estimate_; }

  /// Joint torques, N m, that the encoders' motion would need beside those that were given and felt: the
  /// observer's corrections of velocity, low-passed. Near zero while encoders, force sensor and model agree.
  [[nodiscard]] Eigen::Vector2d unexplained_torque() const noexcept;
  /// Joint torques, N m, that the motion which was predicted for this cycle asks for, with the other sign: a
  /// column for the acceleration of each joint.
  [[nodiscard]] Eigen::Matrix2d predicted_torques() const noexcept;
  /// Joint torques, N m, that torque() gave last.
  [[nodiscard]] const Eigen::Vector2d& given_torque() const noexcept { return given_; }
  /// Joint rates of the last observation, rad/s.
  [[nodiscard]] const Eigen::Vector2d& rates() const noexcept { return rates_; }
  /// Joint torques, N m, that balance the last observed force on the arm.
  [[nodiscard]] Eigen::Vector2d load() const noexcept { return load_of(estimate_.force); }
  /// The same of any force on the arm, N in R.
  [[nodiscard]] Eigen::Vector2d load_of(const Eigen::Vector2d& force) const noexcept {
    return kinematics_.jacobian.transpose() * force;
  }

 private:
  void correct_force(const Reference& reference) noexcept;

  const TwoLink links_;
  const ManipulandumModel model_;
  const ServoGains gains_;
  const double period_;
  const double position_gain_;
  const double velocity_gain_;
  const double trim_decay_;
  const double unexplained_filter_;  // Share of the new value in one cycle.
  const unsigned rest_cycles_needed_;

  bool is_started_ = false;
  bool is_released_ = false;
  unsigned rest_cycles_ = 0;
  DampingWatch damping_watch_;
  TwoLinkState kinematics_;
  Eigen::Vector2d rates_ = Eigen::Vector2d::Zero();         // Joint rates, rad/s.
  Eigen::Vector2d given_ = Eigen::Vector2d::Zero();         // By torque(), N m.
  Eigen::Vector2d acceleration_ = Eigen::Vector2d::Zero();  // Predicted for the period that begins, m/s2.
  Eigen::Vector2d trim_ = Eigen::Vector2d::Zero();          // N.
  Eigen::Vector2d unexplained_ = Eigen::Vector2d::Zero();   // Acceleration at the handle, m/s2.
  HandleEstimate estimate_;
};

}  // namespace tonus::control
