#pragma once

#include <optional>
#include <string>

#include "services/bus/bus.hpp"
#include "services/core/result.hpp"
#include "services/runtime/options.hpp"

namespace tonus::runtime {

/// Where the packets of these options may go, names looked up: `--interface` by its name or address, peers by
/// the system's resolver. This host is among the peers. kInvalidArgument or kUnavailable names the option,
/// its value and what is expected.
[[nodiscard]] Result<bus::NetworkProfile> network_profile(const CommonOptions& options);

/// The IPv4 address, dotted, of a host by its name or address, as the system's resolver has it; none:
/// unknown.
[[nodiscard]] std::optional<std::string> address_of_host(const std::string& host);

}  // namespace tonus::runtime
