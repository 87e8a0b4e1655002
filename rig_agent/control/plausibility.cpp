#include "rig_agent/control/plausibility.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::control {
namespace {

constexpr double kStillTime = 0.05;       // s without a count of either joint: the handle stands still
constexpr double kJointStillTime = 0.10;  // s without a count of one joint, which the other may let stand
constexpr double kSilentWay = 0.003;      // m that the handle may go while a force channel says nothing new
constexpr double kSilentTime = 0.03;  // s that it must last besides: a fast handle and chance are not enough
constexpr double kReactionTime = 0.15;   // s, shortest voluntary reaction of an arm
constexpr double kWorkAllowed = 0.0007;  // J that an arm may give back, and besides
constexpr double kUnrestAllowed = 3.0;   // times the unrest of its force before, over the way
constexpr double kUnrestTime = 0.1;      // s, over which that unrest is taken
constexpr double kMotionShare = 0.7;  // of the motion: only an axis along which the hand goes has much to say

constexpr double kSlow = 0.02;  // rad/s, below which a joint's direction is not sure

/// What may explain the torque that nothing explains.
UnexplainedCauses::Columns causes_of(const PlausibilityInput& input) noexcept {
  const Eigen::Vector2d direction =
      input.rates.array() / (input.rates.array().square() + kSlow * kSlow).sqrt();
  UnexplainedCauses::Columns causes = UnexplainedCauses::Columns::Zero();
  for (int k = 0; k < 2; ++k) {
    causes(k, UnexplainedCauses::kTorques + k) = -input.given[k];
    causes.col(UnexplainedCauses::kChannels + k) = input.channel_loads.col(k);
    causes.col(UnexplainedCauses::kAccelerations + k) = input.predicted.col(k);
    causes(k, UnexplainedCauses::kFriction + k) = -direction[k];
  }
  return causes;
}

std::uint64_t cycles(double duration, double period) {
  return static_cast<std::uint64_t>(std::max(1L, std::lround(duration / period)));
}

}  // namespace

Plausibility::Plausibility(const SafetyLimits& limits, const ServoGains& gains, const JointFriction& friction,
                           const RigGeometry& geometry, double period)
    : limits_(limits),
      period_(period),
      still_cycles_(cycles(kStillTime, period)),
      joint_still_cycles_(cycles(kJointStillTime, period)),
      silent_cycles_(cycles(kSilentTime, period)),
      first_cycles_(cycles(kReactionTime, period)),
      unrest_filter_(1.0 - std::exp(-period / kUnrestTime)),
      way_per_count_((geometry.links.l1 + geometry.links.l2) /
                     std::min(std::abs(geometry.counts_per_unit[0]), std::abs(geometry.counts_per_unit[1]))),
      force_sign_check_(gains, friction, period),
      response_(gains, period),
      encoder_sign_check_(friction, period) {}

FaultBits Plausibility::check(const PlausibilityInput& input) noexcept {
  if (input.is_in_trial && !was_in_trial_) begin_trial(input);
  was_in_trial_ = input.is_in_trial;
  if (!input.is_in_trial) return 0;
  return check_encoders(input) | check_force_channels(input) | check_force_sign(input) |
         check_encoder_sign(input) | check_work(input);
}

void Plausibility::begin_trial(const PlausibilityInput& input) noexcept {
  for (std::size_t i = 0; i < 2; ++i) {
    count_[i] = input.raw.encoder_count[i];
    load_at_count_[i] = input.load[static_cast<Eigen::Index>(i)];
    cycles_still_[i] = 0;
    cycles_loaded_[i] = 0;
    volts_[i] = input.raw.force_V[i];
    count_at_volts_[i] = input.raw.encoder_count;
    cycles_silent_[i] = 0;
  }
  work_by_axis_.setZero();
  cycles_since_onset_ = first_cycles_;
  energy_ = 0.0;
  force_sign_check_.begin_trial();
  response_.start(causes_of(input));
  encoder_sign_check_.begin_trial();
  resting_force_ = input.force;
  unrest_ = 0.0;
}

FaultBits Plausibility::check_encoders(const PlausibilityInput& input) noexcept {
  if (limits_.unexplained_torque <= 0.0) return 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const double load = input.load[static_cast<Eigen::Index>(i)];
    if (input.raw.encoder_count[i] != count_[i]) {
      count_[i] = input.raw.encoder_count[i];
      load_at_count_[i] = load;
      cycles_still_[i] = 0;
      cycles_loaded_[i] = 0;
    }
    ++cycles_still_[i];
    const bool is_loaded = std::abs(load - load_at_count_[i]) > limits_.unexplained_torque;
    cycles_loaded_[i] = is_loaded ? cycles_loaded_[i] + 1 : 0;
  }
  const bool is_handle_still = std::min(cycles_still_[0], cycles_still_[1]) > still_cycles_;
  FaultBits found = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const bool is_still = cycles_still_[i] > joint_still_cycles_;
    if (cycles_loaded_[i] > (is_handle_still ? still_cycles_ : joint_still_cycles_))
      found |= bit(Fault::kEncoderStill);
    if (std::abs(input.unexplained[static_cast<Eigen::Index>(i)]) > limits_.unexplained_torque)
      found |= bit(is_still ? Fault::kEncoderStill : Fault::kEncoderReversed);
  }
  return found;
}

FaultBits Plausibility::check_force_channels(const PlausibilityInput& input) noexcept {
  FaultBits found = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    if (input.raw.force_V[i] != volts_[i]) {
      volts_[i] = input.raw.force_V[i];
      count_at_volts_[i] = input.raw.encoder_count;
      cycles_silent_[i] = 0;
      continue;
    }
    ++cycles_silent_[i];
    const auto& then = count_at_volts_[i];
    const double way = way_per_count_ * std::max(std::abs(input.raw.encoder_count[0] - then[0]),
                                                 std::abs(input.raw.encoder_count[1] - then[1]));
    if (way > kSilentWay && cycles_silent_[i] > silent_cycles_) found |= bit(Fault::kForceStill);
  }
  return found;
}

FaultBits Plausibility::check_force_sign(const PlausibilityInput& input) noexcept {
  if (limits_.unexplained_torque <= 0.0) return 0;
  const bool is_reversed =
      force_sign_check_.finds_reversed(input.unexplained, input.channel_loads, input.predicted);
  return is_reversed ? bit(Fault::kForceAgainstMotion) : 0;
}

FaultBits Plausibility::check_encoder_sign(const PlausibilityInput& input) noexcept {
  if (limits_.unexplained_torque <= 0.0) return 0;
  const UnexplainedCauses::Columns& causes = response_.pass(causes_of(input));
  if (!response_.is_settled()) return 0;
  const bool is_reversed = encoder_sign_check_.finds_reversed(input.unexplained, causes);
  return is_reversed ? bit(Fault::kEncoderReversed) : 0;
}

FaultBits Plausibility::check_work(const PlausibilityInput& input) noexcept {
  FaultBits found = 0;
  energy_ += period_ * input.force.dot(input.velocity);
  if (limits_.trial_energy > 0.0 && energy_ > limits_.trial_energy) found |= bit(Fault::kEnergy);

  if (!input.is_perturbing || input.is_onset) {
    const Eigen::Vector2d deviation = input.force - resting_force_;
    resting_force_ += unrest_filter_ * deviation;
    unrest_ += unrest_filter_ * (deviation.squaredNorm() - unrest_);
  }
  if (input.is_onset) {
    way_ = 0.0;
    work_by_axis_.setZero();
    motion_by_axis_.setZero();
    cycles_since_onset_ = 0;
  }
  if (!input.is_perturbing || cycles_since_onset_ >= first_cycles_) return found;
  ++cycles_since_onset_;
  const Eigen::Vector2d axis(std::cos(input.sensor_angle), std::sin(input.sensor_angle));
  const Eigen::Vector2d other(-axis.y(), axis.x());
  const Eigen::Vector2d force = input.force - resting_force_;
  work_by_axis_ += period_ * Eigen::Vector2d(force.dot(axis) * input.velocity.dot(axis),
                                             force.dot(other) * input.velocity.dot(other));
  const Eigen::Vector2d speeds(input.velocity.dot(axis), input.velocity.dot(other));
  motion_by_axis_ += speeds.cwiseProduct(speeds);
  way_ += period_ * input.velocity.norm();
  const double allowed = kWorkAllowed + kUnrestAllowed * std::sqrt(unrest_) * way_;
  for (Eigen::Index i = 0; i < 2; ++i) {
    const bool is_along = motion_by_axis_[i] > kMotionShare * motion_by_axis_.sum();
    if (is_along && work_by_axis_[i] < -allowed) found |= bit(Fault::kForceAgainstMotion);
  }
  return found;
}

}  // namespace tonus::control
