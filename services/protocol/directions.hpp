#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "services/protocol/draws.hpp"

namespace tonus::protocol {

/// Chances of the directions of the next trial, from how often each has counted so far.
///
/// Law: p_k ~ exp(-b c_k), b the largest for which the entropy -sum p_k log2 p_k is at least `entropy` bits.
/// Of all choices with so much entropy this one keeps the counts most even: it expects the direction that has
/// come least. Without entropy it is a permuted block, whose last direction everybody knows; with log2 of the
/// number of directions each is drawn without memory.
[[nodiscard]] std::vector<double> direction_chances(std::span<const int> counts, double entropy);

/// bits
[[nodiscard]] double entropy_of(std::span<const double> chances);

/// Draws by these chances.
[[nodiscard]] std::size_t draw_by(std::span<const double> chances, Draws& draws);

}  // namespace tonus::protocol
