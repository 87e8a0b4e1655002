#pragma once

#include "services/bus/bus.hpp"

namespace tonus::bus {

/// create_bus for Vendor::kMemory, with options already checked.
[[nodiscard]] Result<std::unique_ptr<Bus>> create_memory_bus(const BusOptions& options);

}  // namespace tonus::bus
