#pragma once

#include "services/bus/bus.hpp"

namespace tonus::bus {

/// create_bus for Vendor::kCycloneDds, with options already checked.
[[nodiscard]] Result<std::unique_ptr<Bus>> create_cyclonedds_bus(const BusOptions& options);

}  // namespace tonus::bus
