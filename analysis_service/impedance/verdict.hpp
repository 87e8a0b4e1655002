#pragma once

#include <optional>

#include "analysis_service/impedance/diagnostics.hpp"
#include "analysis_service/impedance/identification.hpp"

namespace tonus::impedance {

/// Sets status and reasons. A `failure` means undetermined: all numbers are emptied. Otherwise a defect of
/// the data, or a stiffness, mass or (in model (3)) damping whose symmetric part is not positive definite, is
/// suspect.
void conclude(Estimate& estimate, std::optional<Reason> failure, const Diagnosis& diagnosis);

}  // namespace tonus::impedance
