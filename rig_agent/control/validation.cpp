#include "rig_agent/control/validation.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <spdlog/fmt/fmt.h>
#include <string>

namespace tonus::control {
namespace {

// Checks in order, and keeps the first refusal.
class Checks {
 public:
  explicit Checks(const char* subject) : subject_(subject) {}

  Checks& within(const char* field, double value, double low, double high) {
    if (!(value >= low && value <= high)) refuse(field, value, fmt::format("{} to {}", low, high));
    return *this;
  }
  Checks& that(bool holds, const char* field, double value, const std::string& allowed) {
    if (!holds) refuse(field, value, allowed);
    return *this;
  }
  [[nodiscard]] Result<void> result() const { return result_; }

 private:
  void refuse(const char* field, double value, const std::string& allowed) {
    if (!result_) return;
    result_ = fail(ErrorCode::kInvalidArgument,
                   fmt::format("{}: {} is {:.6g}, allowed is {}", subject_, field, value, allowed));
  }

  const char* subject_;
  Result<void> result_;
};

}  // namespace

// Ceilings of this program: no file and no option goes beyond them.
// - Workspace: a seated subject's hand goes about 0.25 m from the middle of its reach before the elbow is
//   straight, where a push goes into the joint itself.
// - Speed and energy: what an arm of some 2 kg at the hand takes up in a stop without harm, 1.5 m/s or 2 J
// and
//   what the centring needs.
// - Force: ISO/TS 15066, annex A, names 140 N for a hand that is held fast; a hand that holds a handle cannot
//   let go at once, and 100 N leave a margin for the sensor. Torque, 100 N m, moves the links too.
// - Time: a person takes 0.2 s to let go; a stop has to come before a second one is needed.
Result<void> validate(const SafetyLimits& limits) {
  return Checks("limits")
      .within("workspace_centre_m[0]", limits.workspace_centre.x(), -10.0, 10.0)
      .within("workspace_centre_m[1]", limits.workspace_centre.y(), -10.0, 10.0)
      .within("workspace_radius_m", limits.workspace_radius, 0.005, 0.25)
      .within("speed_m_per_s", limits.speed, 0.01, 1.5)
      .within("force_N", limits.force, 0.5, 100.0)
      .within("torques_Nm[0]", limits.torque[0], 0.01, 100.0)
      .within("torques_Nm[1]", limits.torque[1], 0.01, 100.0)
      .within("encoder_jump_rad", limits.encoder_jump, 1e-4, 0.1)
      .within("command_timeout_s", limits.command_timeout, 0.0, 5.0)
      .within("missed_periods", limits.missed_periods, 0.0, 10000.0)
      .within("missed_share", limits.missed_share, 0.0, 0.9)
      .within("unexplained_torque_Nm", limits.unexplained_torque, 0.0, 10.0)
      .within("trial_energy_J", limits.trial_energy, 0.0, 10.0)
      .within("watchdog_s", limits.watchdog, 0.005, 0.1)
      .within("safe_damping_Nms_per_rad", limits.safe_damping, 0.1, 10.0)
      .within("safe_torque_Nm", limits.safe_torque, 0.1, 10.0)
      .result();
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
  return Checks("control")
      .within("perturbation_phase_rad", gains.perturbation_phase, 1.0, 10.0)
      .within("perturbation_damping", gains.perturbation_damping, 0.0, 1.0)
      .within("hold_frequency_rad_per_s", gains.hold_frequency, 1.0, 100.0)
      .within("hold_damping", gains.hold_damping, 0.3, 2.0)
      .within("float_damping_per_s", gains.float_damping, 0.1, 100.0)
      .within("force_trim_per_s", gains.force_trim, 0.0, 10.0)
      .within("force_trim_limit_N", gains.force_trim_limit, 0.0, 20.0)
      .within("observer_frequency_rad_per_s", gains.observer_frequency, 5.0, 500.0)
      .within("force_filter_rad_per_s", gains.force_filter, 1.0, 1000.0)
      .within("friction_compensation", gains.friction_compensation, 0.0, 1.0)
      .result();
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
                fmt::format("rig: kind is {}, allowed is two_link for a rig that actuates", kind));
  }
  if (driver.actuates && config.rate < 500.0) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("loop: rate_Hz is {}, allowed is 500 to 4000 for a rig that actuates", config.rate));
  }
  if (!driver.actuates && config.sample_divider != 1) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("loop: sample_divider is {}, allowed is 1 for a recording: every row is a sample",
                            config.sample_divider));
  }
  return {};
}

Result<void> validate(const TrialProgram& program, const SafetyLimits& limits, bool actuates) {
  if (program.number == 0) {
    return fail(ErrorCode::kInvalidArgument, "trial: number is 0, allowed is 1 or more");
  }
  if (!actuates) return {};
  const Eigen::Rotation2Dd shoulder_to_robot(program.shoulder.angle);
  const Eigen::Vector2d target = program.shoulder.origin + shoulder_to_robot * program.posture;
  const double distance = (target - limits.workspace_centre).norm();
  // Twice the step: the underdamped handle overshoots by less than the step itself.
  const double room = limits.workspace_radius - 2.0 * program.amplitude;
  return Checks("trial")
      .within("posture_m[0]", program.posture.x(), -2.0, 2.0)
      .within("posture_m[1]", program.posture.y(), -2.0, 2.0)
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

ShoulderPose shoulder_for(const Eigen::Vector2d& home, const Eigen::Vector2d& p_SE, double angle) {
  ShoulderPose pose;
  pose.angle = angle;
  pose.origin = home - Eigen::Rotation2Dd(angle) * p_SE;
  return pose;
}

}  // namespace tonus::control
