#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "services/mechanics/rig_geometry.hpp"
#include "services/mechanics/two_link_dynamics.hpp"
#include "services/simulation/noise.hpp"
#include "services/simulation/plant_profile.hpp"
#include "services/simulation/subject.hpp"

namespace tonus::simulation {

/// State of both chains, SI: manipulandum's joint angles q in R, arm's joint angles t in S, their rates, and
/// the motors' torques.
struct PlantState {
  Eigen::Vector2d q = Eigen::Vector2d::Zero();
  Eigen::Vector2d q_rate = Eigen::Vector2d::Zero();
  Eigen::Vector2d t = Eigen::Vector2d::Zero();
  Eigen::Vector2d t_rate = Eigen::Vector2d::Zero();
  Eigen::Vector2d motor = Eigen::Vector2d::Zero();
};

/// Manipulandum and arm, joined by the grip:
///
///     H(q) q'' + c(q, q') = motor - friction(q') - J_q^T g          g = k_g (x_q - x_t) + b_g (x'_q - x'_t)
///     I(t) t'' + c(t, t') = subject's torques(t, t') + J_t^T g      motor' = (command - motor) / time
///     constant
///
/// On the bench (BenchProfile) nobody holds the handle: -g is the pull of weights and springs, and the arm
/// rests.
///
/// g is the force on the hand; x_q and x_t are the handle's and the hand's position in R. Integrated by
/// classical Runge-Kutta of fourth order with `sub_steps` fixed steps a period; the command, and what the
/// subject does at random or with delay, is constant within a period, so that the result converges with
/// smaller steps. Deterministic from the profile's seed. step() and measure() are REALTIME.
class Plant {
 public:
  Plant(const PlantProfile& profile, double period);

  /// Seats the subject anew: S at `shoulder` in R, spring centre at `posture` (m in S), hand on the handle at
  /// rest.
  void seat(const ShoulderPose& shoulder, const Eigen::Vector2d& posture) noexcept;

  /// Tells the subject that a trial begins, and what to do in it. REALTIME.
  void begin_trial(const Instruction& instruction = {}) noexcept { subject_.begin_trial(instruction); }

  /// Advances by one period under the commanded joint torques (N m), clipped to the motors' limits.
  void step(const Eigen::Vector2d& torque) noexcept;

  /// Encoder counts (floor) and force volts (noise, clipped, rounded) of the present instant. Draws noise.
  [[nodiscard]] RawSample measure() noexcept;

  [[nodiscard]] const PlantState& state() const noexcept { return state_; }
  [[nodiscard]] std::int64_t time_ns() const noexcept { return step_count_ * period_ns_; }
  /// Handle in R, m.
  [[nodiscard]] Eigen::Vector2d handle() const noexcept;
  /// Force that the flexure feels, on the arm, N in R: grip plus the inertia of the handle beyond the
  /// flexure.
  [[nodiscard]] Eigen::Vector2d flexure_force() const noexcept;
  /// Kinetic energy of both chains plus what the grip's and the arm's springs hold, J.
  [[nodiscard]] double energy() const noexcept;

 private:
  /// What the sub-steps of one period share.
  struct Chains {
    control::TwoLinkState rig;
    control::TwoLinkState arm;
    Eigen::Matrix2d arm_jacobian;  ///< Of the hand in R, m/rad.
    Eigen::Vector2d grip;          ///< N in R, on the hand or on what is fixed to the handle.
  };
  void take_hold() noexcept;
  void runge_kutta_step(const Eigen::Vector2d& command) noexcept;
  [[nodiscard]] Chains chains(const PlantState& state) const noexcept;
  [[nodiscard]] Eigen::Vector4d accelerations(const PlantState& state) const noexcept {
    return accelerations(state, chains(state));
  }
  [[nodiscard]] Eigen::Vector4d accelerations(const PlantState& state, const Chains& c) const noexcept;
  void evaluate_sines() noexcept;

  const PlantProfile profile_;
  const RigGeometry geometry_;
  const control::TwoLinkInertia inertia_;
  const control::TwoLinkInertia arm_inertia_;
  const std::int64_t period_ns_;
  const double period_;
  const double sub_step_;
  const double motor_decay_half_;  // Of the motors' lag in half a sub-step.
  const Eigen::Matrix2d stiffness_;
  const Eigen::Matrix2d damping_;
  Subject subject_;
  NoiseSource sensor_noise_;
  Eigen::Matrix2d shoulder_to_robot_ = Eigen::Matrix2d::Identity();
  Eigen::Vector2d shoulder_origin_ = Eigen::Vector2d::Zero();
  PlantState state_;
  // Where the sines were evaluated last: once a period, at its begin. Within the period they follow from
  // these.
  Eigen::Vector2d q_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d t_ = Eigen::Vector2d::Zero();
  control::TwoLinkState rig_;
  control::TwoLinkState arm_;
  bool is_holding_ = true;
  std::int64_t step_count_ = 0;
};

}  // namespace tonus::simulation
