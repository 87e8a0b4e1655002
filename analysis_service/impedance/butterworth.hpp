#pragma once

#include <Eigen/Core>
#include <array>

#include "analysis_service/impedance/axes.hpp"

namespace tonus::impedance {

/// Second-order digital low-pass, y[k] = b0 u[k] + b1 u[k-1] + b2 u[k-2] - a1 y[k-1] - a2 y[k-2].
struct SecondOrderFilter {
  std::array<double, 3> b{};
  std::array<double, 3> a{};  ///< a[0] = 1.
};

/// Butterworth low-pass by the bilinear transform, its cutoff (Hz, -3 dB) prewarped. 0 < cutoff < 1/(2 h).
[[nodiscard]] SecondOrderFilter butterworth_lowpass(double cutoff, double sample_period);

/// Samples that zero_phase() mirrors at each end; a signal must be longer than this.
inline constexpr Eigen::Index kZeroPhasePadding = 9;

/// Runs the filter over each column forward and backward: no phase shift, the gain squared. Each end is
/// extended by kZeroPhasePadding samples, mirrored through the end point, and each run starts in the steady
/// state of its first sample: the conventions of scipy.signal.filtfilt. Needs more than kZeroPhasePadding
/// rows.
[[nodiscard]] Signals zero_phase(const SecondOrderFilter& filter, const Signals& signals);

/// Central first differences per column, one-sided at the two ends (numpy.gradient).
[[nodiscard]] Signals central_difference(const Signals& signals, double sample_period);

/// Central second differences per column; the ends take their neighbour's value. Needs 3 rows.
[[nodiscard]] Signals second_difference(const Signals& signals, double sample_period);

}  // namespace tonus::impedance
