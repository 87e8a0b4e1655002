#pragma once

#include <random>

#include "analysis_service/certify/drawn_session.hpp"

namespace tonus::certify {

/// simulate_motion() of an arm that M, B, K do not describe, by classical Runge-Kutta steps of 0.2 ms:
///
///     M y" + B y' + K y (1 + h |y|^2 / (5 mm)^2) + r K y(t - d) = F + own force,    Mr x" = Kr (xc - x) - Br
///     x' - F
///
/// y of the hand, x of the handle: the same, but for slack; then F is that of a stiff, damped contact where
/// the handle has moved by more than the slack from the hand.
[[nodiscard]] Motion simulate_imperfect(const Truth& truth, const Design& design,
                                        const Disturbance& disturbance, const ModelError& error,
                                        const Eigen::Vector2d& target, std::mt19937_64& random);

/// Stiffness between rest and 5 mm, N/m: what a slow test would measure.
[[nodiscard]] Eigen::Matrix2d secant_stiffness(const Truth& truth, const ModelError& error);

}  // namespace tonus::certify
