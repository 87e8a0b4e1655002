#pragma once

#include <array>
#include <vector>

#include "services/bus/fastdds/byte_cursor.hpp"

namespace tonus::bus {

/// Bytes to put in the place of others before a datagram is parsed.
struct BytePatch {
  std::size_t at = 0;  ///< From the datagram's first byte.
  std::array<std::byte, 4> bytes{};
  std::size_t count = 0;
};

/// Longest lease that a peer gets, however long it asks for: a peer that fell silent holds up writers and
/// keeps its memory for that long. It is the default of Fast DDS.
inline constexpr std::int32_t kLongestLease_s = 20;

/// True if a parameter list (RTPS 2.3, 9.4.2.11) begins at the cursor and ends with its sentinel; the cursor
/// is then behind that. Of inline QoS, what Fast DDS reads has its right size.
[[nodiscard]] bool is_inline_qos(ByteCursor& cursor);

/// True if a discovery message is a parameter list in which strings, sequences, properties and tokens stay
/// within their parameter, and fixed sizes are right (RTPS 2.3, 9.6.2.2; DDS Security 1.1, 7.2). `at` is the
/// payload's place in its datagram. Adds patches that turn what Fast DDS decodes without bounds, and tonus
/// does not need, into padding, and that shorten leases.
[[nodiscard]] bool is_discovery_payload(std::span<const std::byte> payload, std::size_t at,
                                        std::vector<BytePatch>& patches);

}  // namespace tonus::bus
