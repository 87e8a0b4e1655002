#pragma once

#include <Eigen/Core>
#include <functional>

namespace tonus::impedance {

/// Ends of a 95 % interval; not finite: not determined.
struct Interval {
  double low;
  double high;
};

/// Standard deviation of a combination of a matrix's elements, and the degrees of freedom of that deviation.
struct CombinationSpread {
  double std = 0.0;
  double freedom = 1.0;
};

/// Of the combination of Z11, Z12, Z21, Z22 with these weights.
using SpreadOf = std::function<CombinationSpread(const Eigen::Vector4d& weights)>;

/// 95 % intervals of the numbers of ellipse_of() and curl_of(), in their units.
struct EllipseIntervals {
  Interval size;   ///< Unit squared.
  Interval shape;  ///< From 1.
  /// rad, of a major axis; low <= high, so that an end may lie beyond -pi/2 or pi/2. Not finite where a
  /// circle cannot be excluded: nothing determines the orientation then.
  Interval orientation;
  Interval curl;  ///< p_mean, from 0.
};

/// Intervals by the delta method, deterministic: each number's interval is that of its first-order
/// combination of the elements, Student's t with that combination's degrees of freedom. Size and shape are
/// taken as logarithms, so that their intervals are positive; curl with its sign, an interval that spans 0
/// starts at 0.
///
/// With d = (Z11 - Z22)/2, e = (Z12 + Z21)/2, the matrix is a circle where d = e = 0. The squared length of
/// (d, e) in its own covariance (of row-major elements, 4x4), over 2, is held against the F distribution's 95
/// % quantile: below it a circle is in the joint interval, so that the shape's interval starts at 1 and the
/// orientation has none. The length of (d, e) is too large by half its transverse variance over itself, which
/// is taken into account. All not finite where Z has no ellipse.
[[nodiscard]] EllipseIntervals ellipse_intervals(const Eigen::Matrix2d& Z, const Eigen::Matrix4d& covariance,
                                                 const SpreadOf& spread_of);

/// The smallest intervals that hold both; not finite where either is.
[[nodiscard]] EllipseIntervals hull(const EllipseIntervals& a, const EllipseIntervals& b);

}  // namespace tonus::impedance
