#include "rig_agent/control/servo.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::control {
namespace {

constexpr double kTrimDecayTime = 0.1;  // s, time constant with which the trim is given up.
constexpr double kRestRate = 0.01;      // rad/s; the observer shows less than this at rest.
constexpr double kRestTime = 0.1;       // s.

}  // namespace

// The observer, one axis, with period h, z = exp(-w h) twice as the pole of its error:
//   x <- x + v h + a h^2 / 2 + (1 - z^2) e,   v <- v + a h + (1 - z)^2 / h e,   e = measured - predicted.
Servo::Servo(const TwoLink& links, const ManipulandumModel& model, const ServoGains& gains, double period)
    : links_(links),
      model_(model),
      gains_(gains),
      period_(period),
      position_gain_(1.0 - std::exp(-2.0 * gains.observer_frequency * period)),
      velocity_gain_(std::pow(1.0 - std::exp(-gains.observer_frequency * period), 2) / period),
      trim_decay_(std::exp(-period / kTrimDecayTime)),
      unexplained_filter_(1.0 - std::exp(-kUnexplainedFilter * period)),
      rest_cycles_needed_(static_cast<unsigned>(kRestTime / period)),
      damping_watch_(gains.observer_frequency, period),
      kinematics_(links, Eigen::Vector2d::Zero()) {}

const HandleEstimate& Servo::observe(const Eigen::Vector2d& joint_angles,
                                     const Eigen::Vector2d& force) noexcept {
  kinematics_ = TwoLinkState(links_, joint_angles);
  estimate_.measured = kinematics_.point;
  estimate_.force = force;
  if (!is_started_) {
    is_started_ = true;
    estimate_.position = estimate_.measured;
    estimate_.velocity.setZero();
    acceleration_.setZero();
  }
  const Eigen::Vector2d predicted =
      estimate_.position + period_ * estimate_.velocity + (0.5 * period_ * period_) * acceleration_;
  const Eigen::Vector2d error = estimate_.measured - predicted;
  estimate_.position = predicted + position_gain_ * error;
  estimate_.velocity += period_ * acceleration_ + velocity_gain_ * error;
  rates_ = inverse(kinematics_.jacobian) * estimate_.velocity;
  unexplained_ += unexplained_filter_ * ((velocity_gain_ / period_) * error - unexplained_);
  return estimate_;
}

Eigen::Vector2d Servo::unexplained_torque() const noexcept {
  return model_.inertia.mass_matrix(kinematics_.cos_q2) * (inverse(kinematics_.jacobian) * unexplained_);
}

Eigen::Matrix2d Servo::predicted_torques() const noexcept {
  const Eigen::Vector2d accelerations =
      inverse(kinematics_.jacobian) * (acceleration_ - kinematics_.jacobian_rate_times_rates(rates_));
  return -model_.inertia.mass_matrix(kinematics_.cos_q2) * accelerations.asDiagonal();
}

Eigen::Vector2d Servo::torque(const Reference& reference) noexcept {
  is_released_ = false;
  rest_cycles_ = 0;
  damping_watch_.begin();
  correct_force(reference);

  const bool rings = reference.mode == ServoMode::kRing;
  const double frequency = rings ? reference.frequency : gains_.hold_frequency;
  const double damping = rings ? gains_.perturbation_damping : gains_.hold_damping;
  const Eigen::Vector2d wanted =
      reference.mode == ServoMode::kFloat
          ? Eigen::Vector2d(-gains_.float_damping * estimate_.velocity)
          : Eigen::Vector2d(reference.acceleration +
                            2.0 * damping * frequency * (reference.velocity - estimate_.velocity) +
                            frequency * frequency * (reference.position - estimate_.position));

  const Eigen::Matrix2d& jacobian = kinematics_.jacobian;
  const Eigen::Matrix2d mass_matrix = model_.inertia.mass_matrix(kinematics_.cos_q2);
  const Eigen::Matrix2d inverse_jacobian = inverse(jacobian);
  const Eigen::Vector2d exerted = reference.force + trim_;

  // Lambda^-1 = J H^-1 J': what the force that the arm does not balance adds to the wanted acceleration.
  const Eigen::Vector2d unbalanced = jacobian.transpose() * (exerted - estimate_.force);
  acceleration_ = wanted + jacobian * (inverse(mass_matrix) * unbalanced);

  given_ = mass_matrix * (inverse_jacobian * (wanted - kinematics_.jacobian_rate_times_rates(rates_))) +
           model_.inertia.coriolis(kinematics_.sin_q2, rates_) +
           gains_.friction_compensation * model_.friction.torque(rates_) + jacobian.transpose() * exerted;
  return given_;
}

Eigen::Vector2d Servo::safe_torque(double damping, double limit) noexcept {
  trim_.setZero();
  acceleration_.setZero();
  const bool is_resting = is_started_ && rates_.cwiseAbs().maxCoeff() < kRestRate;
  rest_cycles_ = is_resting ? rest_cycles_ + 1 : 0;
  if (rest_cycles_ >= rest_cycles_needed_) is_released_ = true;
  if (is_released_ || !rates_.allFinite()) return Eigen::Vector2d::Zero();
  const Eigen::Matrix2d mass_matrix = model_.inertia.mass_matrix(kinematics_.cos_q2);
  if (!damping_watch_.takes_energy(mass_matrix, rates_, load())) return Eigen::Vector2d::Zero();
  return (-damping * rates_).cwiseMin(limit).cwiseMax(-limit);
}

void Servo::restart() noexcept {
  is_started_ = false;
  is_released_ = false;
  rest_cycles_ = 0;
  damping_watch_.restart();
  estimate_.velocity.setZero();
  rates_.setZero();
  trim_.setZero();
  unexplained_.setZero();
}

// The trim is integrated only while the force is controlled, kept through the perturbation, and given up
// otherwise.
void Servo::correct_force(const Reference& reference) noexcept {
  if (reference.corrects_force) {
    trim_ += (gains_.force_trim * period_) * (reference.force - estimate_.force);
    trim_ = trim_.cwiseMin(gains_.force_trim_limit).cwiseMax(-gains_.force_trim_limit);
  } else if (reference.mode != ServoMode::kRing) {
    trim_ *= trim_decay_;
  }
}

}  // namespace tonus::control
