#pragma once

#include <cstddef>
#include <span>

#include "services/core/result.hpp"
#include "services/store/records.hpp"

namespace tonus::store {

/// What a message of rig/samples says of itself, without its samples being taken apart: of the archive's time
/// that would be most. Refuses with kInvalidArgument exactly what bus::decode<v1::SampleBlock> refuses (every
/// byte of a sample may have any value, so its length is all there is to check), and beyond that: no
/// samples, and numbers over 2^62. Leaves received_ns, checksum and payload of the block to the caller.
[[nodiscard]] Result<Block> read_block_header(std::span<const std::byte> payload);

/// Likewise of rig/auxiliary. Beyond what bus::decode<v1::AuxiliaryBlock> refuses: no values, a number of
/// samples outside of 1 to 256, values that are not a whole number each sample, and numbers over 2^62.
struct AuxiliaryHeader {
  Block block;
  std::uint32_t values_per_sample = 0;  ///< Of all channels together.
};
[[nodiscard]] Result<AuxiliaryHeader> read_auxiliary_header(std::span<const std::byte> payload);

}  // namespace tonus::store
