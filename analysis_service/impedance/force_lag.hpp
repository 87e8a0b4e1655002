#pragma once

#include <vector>

#include "analysis_service/impedance/condition_response.hpp"

namespace tonus::impedance {

/// Limits of force_lags(); sound data stand well apart from them
/// (tests/unit/analysis_service/impedance/refusal_test.cpp).
inline constexpr double kLagScanned = 0.060;     ///< s, to both sides.
inline constexpr double kLagTolerated = 0.0175;  ///< s.
inline constexpr double kLagMisfitRatio = 1.5;   ///< Misfit without shift over misfit at the best shift.

/// Shift of one force channel against the displacement.
struct ForceLag {
  double time = 0.0;  ///< s; positive: the force is late. 0 where it cannot be told.
  bool is_shifted = false;
  /// Without shift: the misfit, and the root mean square of what model (3) leaves of the mean response over
  /// that of the response's force. 0: not examined.
  double misfit = 0.0;
  double misfit_share = 0.0;
};

/// Finds, channel by channel, the shift of the force at which model (3) fits the condition's mean response
/// best.
///
/// Misfit at a shift: sum of squared residuals of the mean response, over what the trials' own deviations
/// from that response, seen through the same fitted model, make of it; about 1 where the model holds. The
/// denominator matters: encoder noise goes into the residual by M, B and K, so a shift that makes these
/// smaller lowers the residual alone.
///
/// Only shifts count at which M, B and K of the channel's own axis are positive. An arm's force shifted by
/// tau fits with M + tau B + tau^2 K / 2 in the place of M, and leaves (tau M + tau^2 B / 2 + ...) of the
/// displacement's third derivative unexplained, which all but vanishes at tau = -2 M / B: a strongly damped
/// arm fits as well there, but only with a negative mass, which no arm has.
///
/// Shifted: the best shift exceeds kLagTolerated, and either the misfit without shift is kLagMisfitRatio
/// times that of the best one, or what is fitted without shift is no possible arm and fits less well.
///
/// `frequency` (Hz) is that of the motion: examined is the time from 0.1 s before the onset to 1.25 periods
/// after it. Too little rest or motion for that, or fewer than two trials more than axes: all lags are 0.
[[nodiscard]] std::vector<ForceLag> force_lags(const ConditionResponse& response, double frequency);

}  // namespace tonus::impedance
