#pragma once

#include <optional>
#include <span>

#include "analysis_service/impedance/diagnostics.hpp"
#include "analysis_service/impedance/identification.hpp"

namespace tonus::impedance {

/// Identifies perturbations by instrumental variables (analysis_service/refined), model (3), with its checks:
/// explained share, units, lag, mean residual along the command, reflex, hardening, friction. A term counts
/// where it is significant at 1 % over the tests and moves an element of M, B, K beyond its 95 % interval.
///
/// Fills the estimate's numbers, checks and reasons, or returns why there are none. `trials` are in order and
/// last for the window. Intervals: trial-wise covariance CR2, Student's t with the degrees of freedom of Bell
/// and McCaffrey, element by element. `sigma` and `explained` are those behind the test functions.
[[nodiscard]] std::optional<Reason> identify_refined(std::span<const Trial* const> trials,
                                                     const Options& options, const Diagnosis& diagnosis,
                                                     Estimate& estimate);

}  // namespace tonus::impedance
