#pragma once

#include "services/bus/partitions.hpp"

namespace tonus::bus {

/// create_bus for Vendor::kCycloneDds, with options already checked.
[[nodiscard]] Result<std::unique_ptr<Bus>> create_cyclonedds_bus(const BusOptions& options);

/// create_buses likewise.
[[nodiscard]] Result<std::vector<std::unique_ptr<Bus>>> create_cyclonedds_buses(
    const BusOptions& options, const std::vector<Partitions>& places);

}  // namespace tonus::bus
