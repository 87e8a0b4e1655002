#pragma once

#include <cstdint>

namespace tonus::bus {

/// How many packets this process has dropped unread since its start because they were malformed. On Fast DDS
/// alone: Cyclone DDS bears such packets, and does not count them.
[[nodiscard]] std::uint64_t refused_packets();

}  // namespace tonus::bus
