#pragma once

#include <Eigen/Core>

#include "analysis_service/impedance/axes.hpp"

namespace tonus::impedance {

/// Optimally regularised Fourier series of one trajectory (Hatze; method, section 3). For N samples over the
/// duration T = (N-1) h, with the line through the end points taken away, r vanishes at both ends and
///
///     r(t) = sum_k g_k b_k sin(k pi t / T),  b_k = 2/(N-1) sum_n r_n sin(k pi t_n / T),  k = 1 .. N-2,
///     g_k = 1 / (1 + mu (k pi / T)^(2p)),
///
/// mu minimising the generalised cross-validation of n = N - 2 coefficients
///
///     V(mu) = sum (1-g_k)^2 b_k^2 / (n - rho sum g_k)^2.
///
/// Derivatives are those of the series, term by term, plus the line's slope. No constant is set by a user.
/// Deviation: plain cross-validation has rho = 1 and rests on white noise. An encoder's error is a staircase,
/// whose steps it takes for signal: in simulation with the published encoders, mass comes out 90 % too small.
/// rho = 2 (the modified criterion of Cummins, Filloon and Nychka, J. Am. Stat. Assoc. 2001) is within 3 %,
/// and costs little on white noise.
inline constexpr double kCrossValidationCost = 2.0;  ///< rho.

/// Trajectories and their derivatives, samples x axes.
struct OptimalDerivatives {
  Signals value;         ///< p = 2.
  Signals rate;          ///< p = 2.
  Signals acceleration;  ///< p = 3, with its own mu.
};

/// The sine coefficients b_1 .. b_(N-2) of x without the line through its end points. Needs 3 samples.
[[nodiscard]] Eigen::VectorXd sine_coefficients(const Eigen::VectorXd& x);

/// mu at the lowest V for coefficients b of a trajectory of `duration` s: the lowest of a grid over the
/// series' whole band, refined to a root of dV/dmu where the lowest lies inside it. `cost` is rho.
[[nodiscard]] double regularisation(const Eigen::VectorXd& b, double duration, int p,
                                    double cost = kCrossValidationCost);

/// Filters and differentiates each of one or two columns (any unit), sampled every sample_period s. Needs 3
/// rows.
[[nodiscard]] OptimalDerivatives optimal_fourier(const Signals& signals, double sample_period);

}  // namespace tonus::impedance
