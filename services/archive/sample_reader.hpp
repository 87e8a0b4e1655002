#pragma once

#include <vector>

#include "services/archive/store.hpp"

#include <idl/rig.h>

namespace tonus::archive {

/// Every sample of a stream's range, in order and once each, decoded from the blocks as they came.
/// kDataLoss: a block is damaged, or samples are missing; the message says which.
[[nodiscard]] Result<std::vector<v1::RigSample>> read_samples(Store& store, const StreamKey& stream,
                                                              SequenceRange range);

}  // namespace tonus::archive
