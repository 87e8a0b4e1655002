#pragma once

#include <span>

#include "analysis_service/impedance/identification.hpp"

namespace tonus::impedance {

/// Identifies continuous records in the frequency domain (analysis_service/spectral) and concludes: numbers,
/// checks, status and reasons of `estimate`, whose axes are set. The handle's inertia is taken from M. X0 is
/// that of the means, which the preparation has taken away. `model` is one of kRecordModels.
void identify_records(std::span<const Trial* const> trials, Model model, Estimate& estimate);

}  // namespace tonus::impedance
