#include "rig_agent/control/safety_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::control {
namespace {

// s. One encoder count at the handle, up to 0.25 mm, is 0.13 m/s over this time.
constexpr double kSpeedWindow = 0.002;
constexpr double kMissedTime = 1.0;  // s, over which missed periods are counted
// Of the force limit, in one cycle. Two bodies that meet through a hand take some 10 ms to build up a force.
constexpr double kForceJump = 0.25;

}  // namespace

SafetyMonitor::SafetyMonitor(const SafetyLimits& limits, const ServoGains& gains,
                             const JointFriction& friction, const RigGeometry& geometry, double period,
                             bool actuates)
    : limits_(limits),
      geometry_(geometry),
      period_(period),
      actuates_(actuates),
      speed_cycles_(static_cast<std::uint64_t>(std::clamp(std::lround(kSpeedWindow / period), 2L, 15L))),
      missed_filter_(period / kMissedTime),
      plausibility_(limits, gains, friction, geometry, period) {
  positions_.fill(Eigen::Vector2d::Zero());
}

bool SafetyMonitor::begin_cycle(drivers::DriverStatus status, const drivers::Reading& reading,
                                const Surroundings& around) noexcept {
  present_ = 0;
  if (around.is_emergency_stop_asked) found(Fault::kEmergencyStop);
  if (around.is_hold_asked) found(Fault::kHeld);
  if (around.has_watchdog_tripped) found(Fault::kWatchdog);
  check_periods(around.missed_periods);
  check_commander(around);
  if (status != drivers::DriverStatus::kOk) {
    found(Fault::kDriver);
    forget_motion();
    return false;
  }
  if (reading.is_emergency_stop_pressed) found(Fault::kEmergencyStop);
  // A device whose stamps stand still gives the same reading again.
  if (actuates_ && reading.raw.acquisition_ns <= last_acquisition_ns_ && last_acquisition_ns_ != 0)
    found(Fault::kDriver);
  last_acquisition_ns_ = reading.raw.acquisition_ns;
  if (actuates_) check_raw(reading.raw);
  return (present_ & (bit(Fault::kNotFinite) | bit(Fault::kEncoderJump))) == 0;
}

// A recording may miss values and be as fast as it likes: only what can move is held to these.
void SafetyMonitor::check_raw(const RawSample& raw) noexcept {
  for (std::size_t i = 0; i < 2; ++i) {
    if (!std::isfinite(raw.encoder_count[i]) || !std::isfinite(raw.force_V[i])) found(Fault::kNotFinite);
    if (std::abs(raw.force_V[i]) >= geometry_.force_saturation_V) found(Fault::kSensorSaturated);
  }
  if ((present_ & bit(Fault::kNotFinite)) != 0) {
    forget_motion();
    return;
  }
  check_force_channels(raw);
  const Eigen::Vector2d angles = joint_coordinates(geometry_, raw);
  if (has_last_angles_ && (angles - last_angles_).cwiseAbs().maxCoeff() > limits_.encoder_jump) {
    found(Fault::kEncoderJump);
    position_count_ = 0;
  }
  last_angles_ = angles;
  has_last_angles_ = true;
}

void SafetyMonitor::check_force_channels(const RawSample& raw) noexcept {
  for (std::size_t i = 0; i < 2; ++i) {
    const double volts = raw.force_V[i] - last_force_V_[i];
    const double jump =
        std::abs(volts) * geometry_.force_calibration.col(static_cast<Eigen::Index>(i)).norm();
    if (has_last_angles_ && jump > kForceJump * limits_.force) found(Fault::kForceJump);
  }
  last_force_V_ = raw.force_V;
}

void SafetyMonitor::check_periods(unsigned missed_periods) noexcept {
  if (limits_.missed_periods > 0 && missed_periods >= limits_.missed_periods) found(Fault::kOverrun);
  // Of the periods that this cycle stands for, all but its own were missed.
  const double kept = std::pow(1.0 - missed_filter_, static_cast<double>(missed_periods));
  missed_share_ = 1.0 - kept * (1.0 - missed_share_);
  missed_share_ -= missed_filter_ * missed_share_;
  if (limits_.missed_share > 0.0 && missed_share_ > limits_.missed_share) found(Fault::kOverrunRate);
}

void SafetyMonitor::check_plausibility(const PlausibilityInput& input) noexcept {
  if (const FaultBits faults = plausibility_.check(input); faults != 0) found(faults);
}

void SafetyMonitor::check_commander(const Surroundings& around) noexcept {
  if (around.keep_alive != last_keep_alive_ || !was_trial_running_) heard_ns_ = around.now_ns;
  last_keep_alive_ = around.keep_alive;
  was_trial_running_ = around.is_trial_running;
  const double silence = 1e-9 * static_cast<double>(around.now_ns - heard_ns_);
  if (limits_.command_timeout > 0.0 && around.is_trial_running && silence > limits_.command_timeout) {
    found(Fault::kCommandTimeout);
  }
}

// Written so that a value that is not finite is a violation.
void SafetyMonitor::check_handle(const HandleEstimate& handle) noexcept {
  if (!((handle.measured - limits_.workspace_centre).norm() <= limits_.workspace_radius)) {
    found(Fault::kWorkspace);
  }
  const double speed = measured_speed(handle.measured);
  if (!(std::max(handle.velocity.norm(), speed) <= limits_.speed)) found(Fault::kSpeed);
  // No force within the limits gives a handle half that speed in a cycle: it is an encoder, not the hand.
  if (speed > limits_.speed && speed - last_speed_ > 0.5 * limits_.speed) found(Fault::kEncoderJump);
  last_speed_ = speed;
  if (!(handle.force.norm() <= limits_.force)) found(Fault::kForce);
}

double SafetyMonitor::measured_speed(const Eigen::Vector2d& position) noexcept {
  const std::uint64_t now = position_count_++;
  positions_[now % positions_.size()] = position;
  if (now < speed_cycles_) return 0.0;
  const Eigen::Vector2d way = position - positions_[(now - speed_cycles_) % positions_.size()];
  return way.norm() / (static_cast<double>(speed_cycles_) * period_);
}

bool SafetyMonitor::check_torque(const Eigen::Vector2d& torque) noexcept {
  if (!torque.allFinite()) {
    found(Fault::kNotFinite);
    return false;
  }
  if ((torque.cwiseAbs().array() > limits_.torque.array()).any()) {
    found(Fault::kTorque);
    return false;
  }
  return true;
}

void SafetyMonitor::check_write(drivers::DriverStatus status) noexcept {
  if (status != drivers::DriverStatus::kOk) found(Fault::kDriver);
}

FaultBits SafetyMonitor::clear() noexcept {
  if (present_ == 0) latched_ = 0;
  return present_;
}

}  // namespace tonus::control
