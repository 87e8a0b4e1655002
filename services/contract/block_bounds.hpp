#pragma once

#include <cstddef>

/// Bounds of idl/rig.idl that writers and readers of blocks need as numbers.
namespace tonus::contract {

inline constexpr std::size_t kMostBlockSamples = 256;        ///< v1::SampleBlock::samples
inline constexpr std::size_t kMostAuxiliaryValues = 14'000;  ///< v1::AuxiliaryBlock::values

}  // namespace tonus::contract
