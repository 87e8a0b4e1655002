#pragma once

#include <cstddef>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/refined/identification.hpp"

namespace tonus::impedance {

/// What a condition's trials say against model (3), tested beside the fit of method refined
/// (refined/alternatives.hpp), whichever method the estimate is by: the same trials bend every method.

/// Trials from which on these tests are made and a bias is simulated: with fewer no estimate is ok.
inline constexpr std::size_t kFewestTested = 5;

/// Of a test that refuses: 1 % over the six of them.
inline constexpr double kModelSignificance = 0.01 / 6.0;

/// Of a term that is not proven and not to be ruled out: the interval holds the matrix with it and without.
inline constexpr double kDoubtfulBelow = 0.1;

/// Adds the checks for a lag of the force, for what the model leaves of the mean response, and for a reflex,
/// hardening, friction and slack, with a reason for each that failed. `found` has numbers.
void check_against_model(const refined::Estimate& found, Estimate& estimate);

/// The same for tests_by_mean_motion(), but for the mean residual: it is what such a fit was made from.
void check_against_mean_motion(const refined::Estimate& found, Estimate& estimate);

/// Widens the intervals of M, B, K by what each term would change where the trials leave it in doubt. The
/// value stays. Of a reflex it is what M, B, K of slow motion would change: after a ramp a reflex looks like
/// other M, B, K, and these are what is stated (docs/manual/numbers.md).
void carry_doubts(const refined::Estimate& found, Estimate& estimate);

}  // namespace tonus::impedance
