#pragma once

#include <optional>
#include <vector>

#include "analysis_service/impedance/identification.hpp"

namespace tonus::impedance {

/// Time (s) from which on every element of M, B and K stays within `share` of the largest element of its
/// matrix from `final`; none where the trace is empty or settles with its last point only.
[[nodiscard]] std::optional<double> settling_time(const std::vector<ConvergencePoint>& trace,
                                                  const Parameters& final, double share);

}  // namespace tonus::impedance
