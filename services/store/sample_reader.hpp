#pragma once

#include <vector>

#include "services/store/store.hpp"

#include <idl/rig.h>

namespace tonus::store {

/// The message that a block holds. kDataLoss: it cannot be decoded, or is not of the stream and range that
/// the block is filed under. The checksum is the store's matter.
[[nodiscard]] Result<v1::SampleBlock> decode_block(const Block& block);

/// Likewise of a block of auxiliary values.
[[nodiscard]] Result<v1::AuxiliaryBlock> decode_auxiliary_block(const Block& block);

/// Every sample of a stream's range, in order and once each, decoded from the blocks as they came.
/// kDataLoss: a block is damaged, or samples are missing; the message says which.
[[nodiscard]] Result<std::vector<v1::RigSample>> read_samples(Store& store, const StreamKey& stream,
                                                              SequenceRange range);

}  // namespace tonus::store
