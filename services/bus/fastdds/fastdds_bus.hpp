#pragma once

#include "services/bus/partitions.hpp"

namespace tonus::bus {

/// create_bus for Vendor::kFastDds, with options already checked.
[[nodiscard]] Result<std::unique_ptr<Bus>> create_fastdds_bus(const BusOptions& options);

/// create_buses likewise.
[[nodiscard]] Result<std::vector<std::unique_ptr<Bus>>> create_fastdds_buses(
    const BusOptions& options, const std::vector<Partitions>& places);

}  // namespace tonus::bus
