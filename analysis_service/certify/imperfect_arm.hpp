#pragma once

#include <random>

#include "analysis_service/certify/drawn_session.hpp"

namespace tonus::certify {

/// simulate_motion() of an arm that M, B, K do not describe, by classical Runge-Kutta steps of 0.2 ms:
///
///     M y" + B y' + K y (1 + h |y|^2 / (5 mm)^2) + r K y(t - d) + c y'/|y'| = F + own force,
///     Mr x" = Kr (xc - x) - Br x' - F
///
/// y of the hand, x of the handle: the same, but for slack; then F is that of a stiff, damped contact where
/// the handle has moved by more than the slack from the hand.
[[nodiscard]] Motion simulate_imperfect(const Truth& truth, const Design& design,
                                        const Disturbance& disturbance, const ModelError& error,
                                        const Eigen::Vector2d& target, std::mt19937_64& random);

/// What a slow test to 5 mm would measure: K with the reflex and the hardening, between rest and 5 mm, and,
/// by the delay's expansion r K y(t - d) = r K (y - d y' + d^2 y" / 2), what the reflex adds to M and takes
/// from B.
[[nodiscard]] impedance::CartesianImpedance slow_impedance(const Truth& truth, const ModelError& error);

}  // namespace tonus::certify
