#pragma once

#include <Eigen/Core>

namespace tonus {

/// Planar two-link chain, the form shared by the arm (in the shoulder frame S) and the manipulandum (in its
/// base frame R). With link lengths l1, l2 (m), t1 the first joint's angle from +x and t2 the second joint's
/// angle relative to the first link (0 = straight), both in rad and counter-clockwise positive:
///
///     x = l1 cos t1 + l2 cos(t1 + t2)
///     y = l1 sin t1 + l2 sin(t1 + t2)
///
/// All functions are pure, allocate nothing and may be called from a realtime thread.
struct TwoLink {
  double l1 = 0.0;  ///< Length of the first link, m.
  double l2 = 0.0;  ///< Length of the second link, m.

  /// Endpoint (x, y) in m for joint angles (t1, t2) in rad.
  [[nodiscard]] Eigen::Vector2d endpoint(const Eigen::Vector2d& angles) const;

  /// J = d(x, y)/d(t1, t2), m/rad.
  [[nodiscard]] Eigen::Matrix2d jacobian(const Eigen::Vector2d& angles) const;

  /// dJ/dt for joint rates in rad/s, m/(rad s).
  [[nodiscard]] Eigen::Matrix2d jacobian_rate(const Eigen::Vector2d& angles,
                                              const Eigen::Vector2d& rates) const;

  /// Joint angles that reach `point` (m) with the second joint in (0, pi): a right arm, whose elbow lies to
  /// the right. Check reaches() first: a point out of reach gives the nearest straight or folded chain.
  [[nodiscard]] Eigen::Vector2d angles_at(const Eigen::Vector2d& point) const;

  /// True where |l1 - l2| < |point| < l1 + l2, strictly, so that the Jacobian is regular.
  [[nodiscard]] bool reaches(const Eigen::Vector2d& point) const;
};

}  // namespace tonus
