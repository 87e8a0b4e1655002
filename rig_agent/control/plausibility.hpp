#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "rig_agent/control/encoder_sign_check.hpp"
#include "rig_agent/control/fault.hpp"
#include "rig_agent/control/force_sign_check.hpp"
#include "rig_agent/control/observer_response.hpp"
#include "rig_agent/control/safety_limits.hpp"
#include "rig_agent/control/servo_gains.hpp"
#include "rig_agent/control/unexplained_causes.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::control {

/// What one cycle of a trial shows of force, motion and torque. Joint quantities are the shoulder's and the
/// elbow's of the manipulandum.
struct PlausibilityInput {
  RawSample raw;
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();       ///< Of the handle, m/s in R.
  Eigen::Vector2d force = Eigen::Vector2d::Zero();          ///< On the arm, N in R.
  Eigen::Vector2d load = Eigen::Vector2d::Zero();           ///< Joint torques that balance the force, N m.
  Eigen::Vector2d unexplained = Eigen::Vector2d::Zero();    ///< Servo::unexplained_torque(), N m.
  Eigen::Matrix2d channel_loads = Eigen::Matrix2d::Zero();  ///< `load`, a column for each channel.
  Eigen::Matrix2d predicted = Eigen::Matrix2d::Zero();      ///< Servo::predicted_torques(), N m.
  Eigen::Vector2d given = Eigen::Vector2d::Zero();          ///< Torques since the cycle before, N m.
  Eigen::Vector2d rates = Eigen::Vector2d::Zero();          ///< Of the joints, rad/s.
  double sensor_angle = 0.0;                                ///< Of the force sensor's x axis in R, rad.
  bool is_in_trial = false;
  bool is_onset = false;  ///< The perturbation begins in this cycle.
  bool is_perturbing = false;
};

/// Whether force, motion and torque can be those of a handle with an arm. What is wrong in a sensor shows in
/// no limit of its own: an encoder that stands still shows no motion, a force sensor that is dead no force.
///
/// - Encoder: torques that the model of the manipulandum cannot explain, low-passed, beyond
///   SafetyLimits::unexplained_torque; or a joint's load that has changed by more than that since its encoder
///   last moved. No arm is so stiff: at the handle it would be some 25 N/mm.
///   Or an encoder that torque and motion contradict (EncoderSignCheck).
/// - Force: a channel whose volts are the same to the bit while the handle has gone 3 mm; or, in the first
///   0.15 s of a perturbation, when nobody can help along yet, an arm that along a sensor's axis has given
///   back more work than it took; or a channel that torque and motion contradict (ForceSignCheck).
/// - Energy: the work done on the hand since the trial began.
///
/// All methods are REALTIME.
class Plausibility {
 public:
  Plausibility(const SafetyLimits& limits, const ServoGains& gains, const JointFriction& friction,
               const RigGeometry& geometry, double period);

  /// The faults that this cycle shows.
  [[nodiscard]] FaultBits check(const PlausibilityInput& input) noexcept;

 private:
  void begin_trial(const PlausibilityInput& input) noexcept;
  [[nodiscard]] FaultBits check_encoders(const PlausibilityInput& input) noexcept;
  [[nodiscard]] FaultBits check_force_channels(const PlausibilityInput& input) noexcept;
  [[nodiscard]] FaultBits check_force_sign(const PlausibilityInput& input) noexcept;
  [[nodiscard]] FaultBits check_encoder_sign(const PlausibilityInput& input) noexcept;
  [[nodiscard]] FaultBits check_work(const PlausibilityInput& input) noexcept;

  const SafetyLimits limits_;
  const double period_;
  const std::uint64_t still_cycles_;
  const std::uint64_t joint_still_cycles_;
  const std::uint64_t silent_cycles_;
  const std::uint64_t first_cycles_;  // of a perturbation, in which nobody can help along
  const double unrest_filter_;        // Share of the new value in one cycle.
  const double way_per_count_;        // m at the handle, the larger of the two joints'

  ForceSignCheck force_sign_check_;
  ObserverResponse<UnexplainedCauses::kCount> response_;
  EncoderSignCheck encoder_sign_check_;
  bool was_in_trial_ = false;
  std::array<double, 2> count_{};                 // as last seen to change
  std::array<double, 2> load_at_count_{};         // N m, then
  std::array<std::uint64_t, 2> cycles_still_{};   // since then
  std::array<std::uint64_t, 2> cycles_loaded_{};  // without a count, with a load that has changed
  std::array<double, 2> volts_{};                 // as last seen to change
  std::array<std::array<double, 2>, 2> count_at_volts_{};
  std::array<std::uint64_t, 2> cycles_silent_{};
  Eigen::Vector2d resting_force_ = Eigen::Vector2d::Zero();   // N, mean before the perturbation
  double unrest_ = 0.0;                                       // N2, variance about it
  double way_ = 0.0;                                          // m since the onset
  Eigen::Vector2d work_by_axis_ = Eigen::Vector2d::Zero();    // J since the onset, along the sensor's axes
  Eigen::Vector2d motion_by_axis_ = Eigen::Vector2d::Zero();  // speed squared, summed likewise
  std::uint64_t cycles_since_onset_ = 0;
  double energy_ = 0.0;  // J since the trial began
};

}  // namespace tonus::control
