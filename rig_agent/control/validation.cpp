#include "rig_agent/control/validation.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <spdlog/fmt/fmt.h>
#include <string>

#include "rig_agent/control/setting_ranges.hpp"

namespace tonus::control {
namespace {

// Checks in order, and keeps the first refusal.
class Checks {
 public:
  explicit Checks(const char* subject) : subject_(subject) {}

  Checks& within(const std::string& field, double value, double low, double high) {
    if (!(value >= low && value <= high)) refuse(field, value, fmt::format("{} to {}", low, high));
    return *this;
  }
  Checks& within(const std::string& field, const Eigen::Vector2d& value, double low, double high) {
    return within(field + "[0]", value.x(), low, high).within(field + "[1]", value.y(), low, high);
  }
  Checks& that(bool holds, const std::string& field, double value, const std::string& allowed) {
    if (!holds) refuse(field, value, allowed);
    return *this;
  }
  [[nodiscard]] Result<void> result() const { return result_; }

 private:
  void refuse(const std::string& field, double value, const std::string& allowed) {
    if (!result_) return;
    result_ = fail(ErrorCode::kInvalidArgument, fmt::format("{}: {}: {:.6g} is not allowed; expected {}",
                                                            subject_, field, value, allowed));
  }

  const char* subject_;
  Result<void> result_;
};

}  // namespace

Result<void> validate(const SafetyLimits& limits) {
  Checks checks("limits");
  for_each_limit(limits, [&checks](const char* key, const auto& value, auto low, auto high) {
    checks.within(key, value, low, high);
  });
  return checks.result();
}

std::vector<std::string> limits_off(const SafetyLimits& limits) {
  std::vector<std::string> off;
  if (limits.command_timeout <= 0.0) off.emplace_back("command_timeout_s");
  if (limits.missed_periods == 0) off.emplace_back("missed_periods");
  if (limits.missed_share <= 0.0) off.emplace_back("missed_share");
  if (limits.unexplained_torque <= 0.0) off.emplace_back("unexplained_torque_Nm");
  if (limits.trial_energy <= 0.0) off.emplace_back("trial_energy_J");
  return off;
}

Result<void> validate(const ServoGains& gains) {
  Checks checks("control");
  for_each_gain(gains, [&checks](const char* key, double value, double low, double high) {
    checks.within(key, value, low, high);
  });
  return checks.result();
}

Result<void> validate(const LoopConfig& config) {
  if (auto valid = validate(config.limits); !valid) return valid;
  if (auto valid = validate(config.gains); !valid) return valid;
  const TwoLinkInertia& inertia = config.model.inertia;
  return Checks("loop")
      .within("rate_Hz", config.rate, 50.0, 4000.0)
      .within("sample_divider", config.sample_divider, 1.0, 4000.0)
      .within("sample_capacity", static_cast<double>(config.sample_capacity), 16.0, 1e7)
      .that(inertia.inner > 0.0, "model inertia inner (kg m2)", inertia.inner, "more than 0")
      .that(inertia.outer > 0.0, "model inertia outer (kg m2)", inertia.outer, "more than 0")
      .that(inertia.inner * inertia.outer > inertia.coupling * inertia.coupling,
            "model inertia coupling (kg m2)", inertia.coupling, "a positive definite mass matrix")
      .result();
}

Result<void> validate(const LoopConfig& config, const drivers::Capabilities& driver,
                      const RigGeometry& geometry) {
  if (auto valid = validate(config); !valid) return valid;
  if (auto valid = tonus::validate(geometry); !valid) return valid;
  if (driver.actuates && geometry.kind != RigKind::kTwoLink) {
    const char* kind = geometry.kind == RigKind::kOneAxis ? "one_axis" : "cartesian";
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("rig: kind: {} is not allowed; expected two_link for a rig that actuates", kind));
  }
  if (driver.actuates && config.rate < 500.0) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("loop: rate_Hz: {} is not allowed; expected 500 to 4000 for a rig that actuates",
                            config.rate));
  }
  if (!driver.actuates && config.sample_divider != 1) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "loop: sample_divider: {} is not allowed; expected 1 for a recording: every row is a sample",
            config.sample_divider));
  }
  return {};
}

namespace {

Result<void> validate_motion(const TrialProgram& program, const SafetyLimits& limits) {
  const Eigen::Rotation2Dd shoulder_to_robot(program.shoulder.angle);
  const Eigen::Vector2d target = program.shoulder.origin + shoulder_to_robot * program.posture;
  const double distance = (target - limits.workspace_centre).norm();
  // Twice the step: the underdamped handle overshoots by less than the step itself.
  const double room = limits.workspace_radius - 2.0 * program.amplitude;
  return Checks("trial")
      .within("posture_m", program.posture, -2.0, 2.0)
      .that(distance <= room, "distance of the posture from the workspace's centre (m)", distance,
            fmt::format("at most {:.4g} (radius {} less twice the amplitude)", room, limits.workspace_radius))
      .within("centring_time_s", program.centring_time, 0.1, 30.0)
      .within("rest_time_s", program.rest_time, 0.0, 10.0)
      .within("centring_timeout_s", program.centring_timeout, program.centring_time + program.rest_time,
              120.0)
      .within("centring_tolerance_m", program.centring_tolerance, 0.0005, 0.05)
      .within("rest_speed_m_per_s", program.rest_speed, 0.001, 0.1)
      .within("wait_s", program.wait, 0.0, 60.0)
      .that(program.bias.norm() <= 0.5 * limits.force, "bias (N)", program.bias.norm(),
            fmt::format("at most {} (half of the force limit)", 0.5 * limits.force))
      .within("bias_ramp_s", program.bias_ramp, 0.1, 30.0)
      .within("bias_hold_s", program.bias_hold, 0.0, 30.0)
      .within("bias_threshold_N", program.bias_threshold, 0.01, 10.0)
      .within("bias_timeout_s", program.bias_timeout, program.bias_hold, 120.0)
      .within("direction_rad", program.direction, -4.0 * std::numbers::pi, 4.0 * std::numbers::pi)
      .within("amplitude_m", program.amplitude, 0.0, 0.05)
      .within("rise_time_s", program.rise_time, 0.05, 2.0)
      .within("hold_s", program.hold, 0.05, 60.0)
      .within("return_time_s", program.return_time, 0.1, 30.0)
      .result();
}

}  // namespace

Result<void> validate(const TrialProgram& program, const SafetyLimits& limits, bool actuates) {
  if (program.number == 0) {
    return fail(ErrorCode::kInvalidArgument, "trial: number: 0 is not allowed; expected 1 or more");
  }
  if (!actuates) return {};
  TrialProgram moved = program;
  if (program.kind == TrialKind::kContraction) {  // what it does not use says nothing
    const TrialProgram unused;
    moved.bias = unused.bias;
    moved.direction = unused.direction;
    moved.amplitude = 0.0;
    moved.rise_time = unused.rise_time;
  }
  return validate_motion(moved, limits);
}

ShoulderPose shoulder_for(const Eigen::Vector2d& home, const Eigen::Vector2d& p_SE, double angle) {
  ShoulderPose pose;
  pose.angle = angle;
  pose.origin = home - Eigen::Rotation2Dd(angle) * p_SE;
  return pose;
}

}  // namespace tonus::control
