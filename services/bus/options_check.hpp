#pragma once

#include "services/bus/bus.hpp"

namespace tonus::bus {

/// kInvalidArgument names the option, its value and what is allowed.
[[nodiscard]] Result<void> check_options(const BusOptions& options);

}  // namespace tonus::bus
