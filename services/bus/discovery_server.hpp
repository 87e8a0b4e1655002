#pragma once

#include <memory>

#include "services/bus/bus.hpp"

namespace tonus::bus {

/// A discovery server of Fast DDS: the one place that participants with
/// NetworkProfile::discovery_servers ask where the others are. It carries no messages of theirs: what has
/// found each other goes on without it. Runs until this object goes.
class DiscoveryServer {
 public:
  virtual ~DiscoveryServer() = default;

  /// Listens at the interface address of `options` and `port`. kInvalidArgument: not Fast DDS, or an option
  /// is wrong; kUnavailable: the port is in use.
  [[nodiscard]] static Result<std::unique_ptr<DiscoveryServer>> start(const BusOptions& options,
                                                                      std::uint16_t port);
};

}  // namespace tonus::bus
