#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "analysis_service/impedance/ellipse_intervals.hpp"
#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/joint_space.hpp"

namespace tonus::impedance {

/// Impedance at a posture with what is known of its errors.
struct UncertainPosture {
  PostureImpedance value;
  Eigen::MatrixXd covariance;  ///< 12x12: M, B, K, each row by row.
  double freedom = 1.0;        ///< Degrees of freedom behind it.
  CartesianImpedance bias{Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero(),
                          Eigen::Matrix2d::Zero()};  ///< Known bias; zero: none, or not simulated.
};

/// Of a two-axis estimate by model (3) that has numbers and a covariance of vec(Theta); none otherwise.
[[nodiscard]] std::optional<UncertainPosture> uncertain_posture(const Eigen::Vector2d& position,
                                                                const Estimate& estimate);

/// Numbers computed from the impedance at several postures: link masses, joint constants. None where they
/// cannot be computed.
using FromPostures = std::function<std::optional<Eigen::VectorXd>(std::span<const PostureImpedance>)>;

/// 95 % intervals of such numbers: their first-order change with each element of each posture (central
/// differences of a tenth of its standard error) through the covariances, postures being independent;
/// Student's t with the degrees of freedom of Welch and Satterthwaite. Each interval is widened to hold
/// itself and what it is without the known bias. They say what the elements' errors do to the numbers, not
/// how well the model (cylinders, one constant) describes the arm. Empty where the numbers cannot be
/// computed.
[[nodiscard]] std::vector<Interval> propagate(std::span<const UncertainPosture> postures,
                                              const FromPostures& compute);

}  // namespace tonus::impedance
