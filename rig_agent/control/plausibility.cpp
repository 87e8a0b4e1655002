#include "rig_agent/control/plausibility.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::control {
namespace {

constexpr double kStillTime = 0.05;       // s without a count of either joint: the handle stands still
constexpr double kJointStillTime = 0.10;  // s without a count of one joint, which the other may let stand
constexpr double kSilentWay = 0.003;      // m that the handle may go while a force channel says nothing new
constexpr double kReactionTime = 0.15;    // s, shortest voluntary reaction of an arm
constexpr double kWorkAllowed = 0.0012;   // J that an arm may give back: drift and tremor over this time
constexpr double kWorkShare = 0.35;       // of all work, for what the axes exchange

std::uint64_t cycles(double duration, double period) {
  return static_cast<std::uint64_t>(std::max(1L, std::lround(duration / period)));
}

}  // namespace

Plausibility::Plausibility(const SafetyLimits& limits, const RigGeometry& geometry, double period)
    : limits_(limits),
      period_(period),
      still_cycles_(cycles(kStillTime, period)),
      joint_still_cycles_(cycles(kJointStillTime, period)),
      first_cycles_(cycles(kReactionTime, period)),
      way_per_count_((geometry.links.l1 + geometry.links.l2) /
                     std::min(std::abs(geometry.counts_per_unit[0]), std::abs(geometry.counts_per_unit[1]))) {
}

FaultBits Plausibility::check(const PlausibilityInput& input) noexcept {
  if (input.is_in_trial && !was_in_trial_) begin_trial(input);
  was_in_trial_ = input.is_in_trial;
  if (!input.is_in_trial) return 0;
  return check_encoders(input) | check_force_channels(input) | check_work(input);
}

void Plausibility::begin_trial(const PlausibilityInput& input) noexcept {
  for (std::size_t i = 0; i < 2; ++i) {
    count_[i] = input.raw.encoder_count[i];
    load_at_count_[i] = input.load[static_cast<Eigen::Index>(i)];
    cycles_still_[i] = 0;
    cycles_loaded_[i] = 0;
    volts_[i] = input.raw.force_V[i];
    count_at_volts_[i] = input.raw.encoder_count;
  }
  work_by_axis_.setZero();
  cycles_since_onset_ = first_cycles_;
  energy_ = 0.0;
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
      continue;
    }
    const auto& then = count_at_volts_[i];
    const double way = way_per_count_ * std::max(std::abs(input.raw.encoder_count[0] - then[0]),
                                                 std::abs(input.raw.encoder_count[1] - then[1]));
    if (way > kSilentWay) found |= bit(Fault::kForceStill);
  }
  return found;
}

FaultBits Plausibility::check_work(const PlausibilityInput& input) noexcept {
  FaultBits found = 0;
  energy_ += period_ * input.force.dot(input.velocity);
  if (limits_.trial_energy > 0.0 && energy_ > limits_.trial_energy) found |= bit(Fault::kEnergy);

  if (input.is_onset) {
    force_at_onset_ = input.force;
    work_by_axis_.setZero();
    cycles_since_onset_ = 0;
  }
  if (!input.is_perturbing || cycles_since_onset_ >= first_cycles_) return found;
  ++cycles_since_onset_;
  const Eigen::Vector2d axis(std::cos(input.sensor_angle), std::sin(input.sensor_angle));
  const Eigen::Vector2d other(-axis.y(), axis.x());
  const Eigen::Vector2d force = input.force - force_at_onset_;
  work_by_axis_ += period_ * Eigen::Vector2d(force.dot(axis) * input.velocity.dot(axis),
                                             force.dot(other) * input.velocity.dot(other));
  const double allowed = std::max(kWorkAllowed, kWorkShare * work_by_axis_.cwiseAbs().sum());
  if (work_by_axis_.minCoeff() < -allowed) found |= bit(Fault::kForceReversed);
  return found;
}

}  // namespace tonus::control
