#pragma once

#include <span>

#include "analysis_service/impedance/trial.hpp"
#include "analysis_service/refined/identification.hpp"

namespace tonus::impedance {

/// What the motion of a condition's trials has in common, with its derivatives, at the samples' rate:
/// measured, whatever moved the hand. `targets` are the trials' mean displacements over the window (m) and,
/// with these as U, of_axis is R(t) = sum_j x_j(t) u_j' (U'U)^-1, over the rows that all trials have around
/// their onsets.
///
/// Law: R(t) less the line through its ends is expanded in sines, b_k sin(k pi t / T), as in optimal_fourier.
/// The harmonics up to the first ones that do not stand out of the noise, which is that of the upper quarter
/// of the series, are kept as they are: x, v and a are exact derivatives of one band-limited motion. It
/// begins at the onset; the rest before it is zero.
///
/// The trials last for `window` s; at least one. No rest and no motion where their mean displacements do not
/// span the axes.
[[nodiscard]] refined::CommandMotion mean_motion(std::span<const Trial* const> trials, double window);

}  // namespace tonus::impedance
