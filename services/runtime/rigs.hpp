#pragma once

#include <memory>
#include <string>
#include <vector>

#include "services/bus/partitions.hpp"
#include "services/core/result.hpp"
#include "services/runtime/options.hpp"

/// Services that serve several rigs in one process. Each rig is a partition of its name.
namespace tonus::runtime {

inline constexpr std::size_t kMostRigs = 64;  ///< As many as tests/bench/rigs measures.

/// --rigs, for a service that can.
void add_rigs_option(CLI::App& app, std::vector<std::string>& rigs);

/// `common` for each rig that is served, its name in `rig`: those of --rigs, else the one of --rig.
/// kInvalidArgument: a name twice, or more than kMostRigs.
[[nodiscard]] Result<std::vector<CommonOptions>> each_rig(const CommonOptions& common,
                                                          const std::vector<std::string>& rigs);

/// "left, right", or how many where the line would be long; empty where there is only one.
[[nodiscard]] std::string rigs_text(const std::vector<CommonOptions>& rigs);

/// What the options say of the bus, without a partition. kInvalidArgument and what the certificates' check
/// says.
[[nodiscard]] Result<bus::BusOptions> bus_options_of(const CommonOptions& options,
                                                     const std::string& program);

/// One participant with a bus for each rig, in its partition. As open_bus().
[[nodiscard]] Result<std::vector<std::unique_ptr<bus::Bus>>> open_buses(
    const std::vector<CommonOptions>& rigs, const std::string& program);

}  // namespace tonus::runtime
