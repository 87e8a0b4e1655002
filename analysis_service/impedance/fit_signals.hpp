#pragma once

#include <Eigen/Core>
#include <span>

#include "analysis_service/impedance/axes.hpp"
#include "analysis_service/impedance/options.hpp"
#include "analysis_service/impedance/trial.hpp"
#include "services/core/result.hpp"

namespace tonus::impedance {

/// What a method makes of one trial: the two sides of the model, row by row of the trial.
struct FitSignals {
  Signals acceleration;    ///< x", samples x axes.
  Signals velocity_terms;  ///< x' (3), none (13), its products (14) or squares (15).
  Signals displacement;    ///< x.
  Signals force;           ///< F, with the handle's inertia m_h x" taken away.
};

/// Fewest rows that a method can work on.
inline constexpr Eigen::Index kFewestRows = 16;

/// Second processing step (method, section 3). `natural_frequency` (Hz) is used by state_variable only.
///
/// lowpass: zero-phase filter, central differences; the force as it is, or through the same filter.
/// optimal: regularised Fourier series of each axis over the whole trial; the force as it is.
/// state_variable: both sides through T(s), started at rest with the force's mean of the rest taken away and
/// put back behind it, as T(0) = 1; a bias force and the constant of the model are thus treated alike. In
/// (14), (15) the products of the velocity are formed before T(s), from the low-pass velocity: T(s) of a
/// product is not the product of the filtered velocities.
///
/// The trial must have kFewestRows rows or more.
[[nodiscard]] FitSignals fit_signals(const Trial& trial, const Options& options, double natural_frequency);

/// The mean force of the rest, 0 in a continuous record.
[[nodiscard]] AxisVector rest_force(const Trial& trial);

}  // namespace tonus::impedance
