#pragma once

#include <Eigen/Core>
#include <optional>

namespace tonus::impedance {

/// How a matrix changed against its reference: loaded against unloaded, or under an instruction (method,
/// section 8).
struct Modulation {
  double size_ratio = 1.0;   ///< (7b) of the changed over that of the reference.
  double shape_ratio = 1.0;  ///< (7c) likewise.
  double rotation = 0.0;  ///< rad, change of orientation (7d) in (-pi/2, pi/2], counter-clockwise positive.
  bool has_rotation = true;  ///< False where either ellipse is a circle.
};

/// None where either matrix is not positive definite.
[[nodiscard]] std::optional<Modulation> modulation(const Eigen::Matrix2d& changed,
                                                   const Eigen::Matrix2d& reference);

}  // namespace tonus::impedance
