#pragma once

#include <string>

#include "rig_agent/control/fault.hpp"

namespace tonus::control {

/// "workspace, speed"; empty for none. Not realtime.
[[nodiscard]] std::string fault_text(FaultBits faults);

}  // namespace tonus::control
