#pragma once

#include <functional>
#include <string>

#include "services/core/result.hpp"

namespace tonus::watchdog {

/// How a process that is not the rig agent drops the torque of a driver ("library", "comedi"); its file and
/// options are the agent's. What the function returns: the device has confirmed it. The errors name what is
/// wrong with the file; kInvalidArgument where the driver cannot be disabled from outside.
[[nodiscard]] Result<std::function<bool()>> disable_of(const std::string& driver, const std::string& file,
                                                       const std::string& options);

}  // namespace tonus::watchdog
