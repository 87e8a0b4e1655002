#pragma once

#include <span>

#include "analysis_service/impedance/identification.hpp"

namespace tonus::impedance {

/// Identifies continuous records in the frequency domain (analysis_service/spectral) and concludes: numbers,
/// checks, status and reasons of `estimate`, whose axes are set. The handle's inertia is taken from M. X0 is
/// that of the means, which the preparation has taken away. `model` is one of kRecordModels.
void identify_records(std::span<const Trial* const> trials, Model model, Estimate& estimate);

/// Holds the numbers of a published method against those of method spectral for the same records, model (3).
/// In continuous records the published methods err by several of their half-widths (their discretisation, the
/// noise of the motion), which no scatter of blocks shows: what they give beyond spectral is their known
/// bias, and their intervals hold spectral's as well. What spectral finds amiss is amiss with the data and
/// becomes a reason here, before conclude().
void hold_against_spectral(const Estimate& spectral, Estimate& estimate);

}  // namespace tonus::impedance
