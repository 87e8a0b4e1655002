#pragma once

#include <Eigen/Core>
#include <span>

#include "analysis_service/impedance/axes.hpp"
#include "analysis_service/impedance/trial.hpp"

namespace tonus::impedance {

/// Frequency (Hz) at which the displacement's Fourier transform peaks, over rows [first, first + rows).
///
/// Rule: the mean of each axis over these rows is taken away (a step's response has its largest component at
/// 0 Hz, which says nothing about its oscillation); the transform is zero-padded to at least eight times the
/// rows; the power of all axes is summed, which makes the peak independent of the frame; the highest value
/// between half a period in the window and a quarter of the sampling rate is refined by a parabola through
/// its neighbours. 0 where the displacement does not move.
[[nodiscard]] double peak_frequency(const Signals& displacement, Eigen::Index first, Eigen::Index rows,
                                    double sample_period);

/// wn / (2 pi) of (8), Hz: the mean of the trajectories' peak frequencies (method, section 3), each over
/// `window` s from its onset; a continuous record counts as trajectories of `block` s. 0 where nothing moves.
[[nodiscard]] double tuned_natural_frequency(std::span<const Trial* const> trials, double window,
                                             double block);

}  // namespace tonus::impedance
