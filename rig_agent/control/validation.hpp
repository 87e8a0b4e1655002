#pragma once

#include <string>
#include <vector>

#include "rig_agent/control/rig_loop.hpp"
#include "rig_agent/control/safety_limits.hpp"
#include "rig_agent/control/servo_gains.hpp"
#include "rig_agent/control/trial_program.hpp"
#include "rig_agent/drivers/driver.hpp"
#include "services/core/result.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::control {

// Not realtime. Each refuses with one line that names the field, its value and what is allowed; the fields
// are named as on the wire and in files, with their unit.

[[nodiscard]] Result<void> validate(const SafetyLimits& limits);
/// Names of the limits that are switched off, as in a rig's file.
[[nodiscard]] std::vector<std::string> limits_off(const SafetyLimits& limits);
[[nodiscard]] Result<void> validate(const ServoGains& gains);
[[nodiscard]] Result<void> validate(const LoopConfig& config);
/// Also refuses a config that does not fit the driver: only two-link rigs actuate, at 500 Hz or more, and of
/// a recording every row is a sample.
[[nodiscard]] Result<void> validate(const LoopConfig& config, const drivers::Capabilities& driver,
                                    const RigGeometry& geometry);

/// Also refuses a posture that stands outside the limits' workspace in R, or a perturbation that could leave
/// it. `actuates` is false for recordings, whose programs need only a number.
[[nodiscard]] Result<void> validate(const TrialProgram& program, const SafetyLimits& limits,
                                    bool actuates = true);

/// The shoulder pose that puts posture p_SE (m) under a handle at `home` (m, in R), S turned by `angle`
/// (rad).
[[nodiscard]] ShoulderPose shoulder_for(const Eigen::Vector2d& home, const Eigen::Vector2d& p_SE,
                                        double angle = 0.0);

}  // namespace tonus::control
