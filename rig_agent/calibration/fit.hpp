#pragma once

#include <Eigen/Core>
#include <span>

#include "services/core/result.hpp"

namespace tonus::calibration {

/// A known load on the force sensor.
struct KnownForce {
  Eigen::Vector2d force = Eigen::Vector2d::Zero();  ///< N, on the arm, in the sensor's frame.
  Eigen::Vector2d volts = Eigen::Vector2d::Zero();  ///< V, mean.
};

/// f = matrix (v - offset), and how far the readings are from it.
struct ForceFit {
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Identity();  ///< N/V.
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();      ///< V.
  double residual = 0.0;  ///< N, root mean square over readings and axes, of 2 n - 6 degrees of freedom.
};

/// Least squares of the six numbers of f = C v + d over the readings; offset = -C^-1 d. Refuses fewer than
/// four readings, and loads whose volts do not span the plane (ratio of the singular values of the centred
/// volts under 0.1).
[[nodiscard]] Result<ForceFit> fit_force(std::span<const KnownForce> readings);

/// What one step away from the spring's place of rest changed.
struct SpringStep {
  Eigen::Vector2d displacement = Eigen::Vector2d::Zero();  ///< m.
  Eigen::Vector2d force = Eigen::Vector2d::Zero();         ///< N, on the spring.
};

/// f = stiffness x.
struct SpringFit {
  Eigen::Matrix2d stiffness = Eigen::Matrix2d::Zero();       ///< N/m, not made symmetric.
  Eigen::Matrix2d standard_error = Eigen::Matrix2d::Zero();  ///< N/m, of each element, from the residuals.
  double residual = 0.0;                                     ///< N, as in ForceFit.

  /// Stiffness along a direction (rad): u' K u.
  [[nodiscard]] double along(double direction) const;
  /// Mean over all directions: half the trace.
  [[nodiscard]] double mean() const { return 0.5 * stiffness.trace(); }
};

/// Least squares over the steps. Refuses fewer than four, and steps that do not span the plane.
[[nodiscard]] Result<SpringFit> fit_spring(std::span<const SpringStep> steps);

}  // namespace tonus::calibration
