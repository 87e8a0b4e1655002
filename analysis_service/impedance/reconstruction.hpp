#pragma once

#include <span>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/trial.hpp"

namespace tonus::impedance {

/// Average fitting error (16) of the measured force, N rms per axis: e is what is measured minus what the
/// estimate's model makes of the measured displacement, over the estimate's trials and the options' window.
/// Velocity and acceleration are those of the low-pass method with the options' cutoff; the force is
/// unfiltered.
///
/// Why beside Estimate::sigma: the paper speaks of "deviations from the measured force values".
/// State-variable filtering (8) with its damping ratio of 0.1 passes its own frequency with a gain of 5 and
/// tremor at 9 Hz with one of 0.1; the error of the filtered force is on another scale than Table II.
///
/// Errors (kInvalidArgument): an undetermined estimate, options out of limits, none of its trials given. Pure
/// and thread-safe; allocates.
[[nodiscard]] Result<AxisVector> reconstruction_error(std::span<const Trial> trials, const Estimate& estimate,
                                                      const Options& options);

}  // namespace tonus::impedance
