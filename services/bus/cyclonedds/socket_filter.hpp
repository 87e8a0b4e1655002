#pragma once

#include <cstddef>
#include <string>

#include "services/core/result.hpp"

namespace tonus::bus {

/// Cyclone DDS 0.10 binds its receiving sockets to 0.0.0.0 whatever interface it is told. Has the kernel drop
/// what arrives at this process's sockets of an RTPS domain under another address than `interface_address`
/// (IPv4, dotted), as if they were bound to it; sockets that were confined before stay as they are. Returns
/// how many sockets are confined now that were not: 0 means that Cyclone opened none where it should have.
/// kUnavailable: the kernel refused.
[[nodiscard]] Result<std::size_t> accept_only_at(const std::string& interface_address, int domain);

}  // namespace tonus::bus
