#pragma once

#include <memory>
#include <string>
#include <vector>

#include "services/bus/bus.hpp"

namespace tonus::bus {

/// Names of partitions; writers and readers in several are matched with those of each one.
using Partitions = std::vector<std::string>;

/// One participant with a Bus for each of `places`: its writers and readers are in that place's partitions.
/// `options.partition` is not used. The participant goes with the last Bus, writer or reader. kMemory has no
/// partitions: each Bus hears all. Errors as of create_bus; kInvalidArgument for a place without partition.
[[nodiscard]] Result<std::vector<std::unique_ptr<Bus>>> create_buses(const BusOptions& options,
                                                                     const std::vector<Partitions>& places);

}  // namespace tonus::bus
