#pragma once

#include <cstddef>
#include <span>

#include "analysis_service/identification/measured_trial.hpp"

namespace tonus::identification {

/// Where in a trial's rows the parts lie, as [first, end) by index.
struct Section {
  std::size_t first = 0;
  std::size_t end = 0;

  [[nodiscard]] std::size_t rows() const { return end - first; }
};

/// The rest before the onset: rows that end at it and are waiting or holding the bias (or bear no phase at
/// all, as in a recording), at most `most_rows` of them.
[[nodiscard]] Section rest_before(std::span<const Row> rows, std::size_t onset, std::size_t most_rows);

/// The hold of the bias force that ends at the onset, at most `most_rows` of it.
[[nodiscard]] Section bias_hold_before(std::span<const Row> rows, std::size_t onset, std::size_t most_rows);

/// The perturbation: from the onset up to the way back, or to the last row where there is none.
[[nodiscard]] Section perturbation_from(std::span<const Row> rows, std::size_t onset);

/// Rows that a duration (s) has at a rate (Hz), at least `least`.
[[nodiscard]] std::size_t rows_of(double duration, double sample_rate, std::size_t least = 1);

}  // namespace tonus::identification
