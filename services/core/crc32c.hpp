#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tonus {

/// CRC-32C (Castagnoli; RFC 3720, appendix B.4: "123456789" gives E3069283), the checksum of everything that
/// is kept on disk.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::byte> bytes);

}  // namespace tonus
