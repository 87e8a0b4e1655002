#include "analysis_service/impedance/ellipse_intervals.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis_service/impedance/ellipse.hpp"
#include "analysis_service/statistics/distributions.hpp"

namespace tonus::impedance {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr Interval kNone{kUnknown, kUnknown};

double half_width(const SpreadOf& spread_of, const Eigen::Vector4d& weights) {
  const CombinationSpread spread = spread_of(weights);
  return statistics::student_t_factor(0.95, std::max(1.0, spread.freedom)) * spread.std;
}

/// exp of value give or take half.
Interval of_logarithm(double value, double half) { return {value * std::exp(-half), value * std::exp(half)}; }

/// (d, e) from row-major elements.
Eigen::Matrix<double, 2, 4> deviator() {
  Eigen::Matrix<double, 2, 4> D;
  D << 0.5, 0.0, 0.0, -0.5, 0.0, 0.5, 0.5, 0.0;
  return D;
}

bool may_be_circle(const Eigen::Vector2d& apart, const Eigen::Matrix2d& covariance, double freedom) {
  const double squares = apart.dot(covariance.ldlt().solve(apart));
  // Hotelling's T2 of two numbers whose covariance has `freedom` degrees of freedom.
  const double below = std::max(1.0, freedom - 1.0);
  return !(squares * below / (2.0 * std::max(1.0, freedom)) > statistics::fisher_quantile(0.95, 2.0, below));
}

Interval joined(const Interval& a, const Interval& b) {
  return {std::isfinite(b.low) ? std::min(a.low, b.low) : kUnknown,
          std::isfinite(b.high) ? std::max(a.high, b.high) : kUnknown};
}

/// b turned by whole half turns until its middle is next to that of a.
Interval beside(const Interval& a, Interval b) {
  const double turn =
      std::numbers::pi * std::round(0.5 * (a.low + a.high - b.low - b.high) / std::numbers::pi);
  return {b.low + turn, b.high + turn};
}

}  // namespace

EllipseIntervals ellipse_intervals(const Eigen::Matrix2d& Z, const Eigen::Matrix4d& covariance,
                                   const SpreadOf& spread_of) {
  EllipseIntervals intervals{kNone, kNone, kNone, kNone};
  const auto ellipse = ellipse_of(Z);
  if (!ellipse || !covariance.allFinite()) return intervals;
  const double l1 = ellipse->minor;
  const double l2 = ellipse->major;
  const Eigen::Matrix2d Zs = symmetric_part(Z);
  const Eigen::Vector4d mean(0.5, 0.0, 0.0, 0.5);
  const Eigen::Matrix<double, 2, 4> D = deviator();
  const Eigen::Vector2d apart(0.5 * (Zs(0, 0) - Zs(1, 1)), Zs(0, 1));
  const double r = apart.norm();
  const Eigen::Vector2d along =
      r > 0.0 ? Eigen::Vector2d(apart / r) : Eigen::Vector2d(Eigen::Vector2d::UnitX());
  const Eigen::Vector2d across(-along[1], along[0]);
  const Eigen::Vector4d length = D.transpose() * along;  // of (d, e)
  const Eigen::Vector4d major = mean + length;
  const Eigen::Vector4d minor = mean - length;

  intervals.size = of_logarithm(ellipse->size, half_width(spread_of, major / l2 + minor / l1));

  const Eigen::Vector4d antisymmetric(0.0, 0.5, -0.5, 0.0);
  const double za = 0.5 * (Z(0, 1) - Z(1, 0));
  const double root = std::sqrt(l1 * l2);
  const double half =
      half_width(spread_of, antisymmetric / root - 0.5 * za / root * (major / l2 + minor / l1));
  const double curl = std::abs(za) / root;
  intervals.curl = {std::max(0.0, curl - half), curl + half};

  const Eigen::Vector4d turn = D.transpose() * across;
  const Eigen::Matrix2d C = D * covariance * D.transpose();
  const double freedom = std::min(spread_of(length).freedom, spread_of(turn).freedom);
  const bool is_circle = ellipse->is_circle || may_be_circle(apart, C, freedom);
  const double too_long = r > 0.0 ? std::min(r, 0.5 * across.dot(C * across) / r) : 0.0;
  const double middle = ellipse->shape * std::exp(-too_long * (1.0 / l2 + 1.0 / l1));
  intervals.shape = of_logarithm(middle, half_width(spread_of, major / l2 - minor / l1));
  intervals.shape.low = is_circle ? 1.0 : std::max(1.0, intervals.shape.low);
  intervals.shape.high = std::max(intervals.shape.high, ellipse->shape);
  if (!is_circle) {
    const double width = half_width(spread_of, turn / (2.0 * r));
    intervals.orientation = {ellipse->orientation - width, ellipse->orientation + width};
  }
  return intervals;
}

EllipseIntervals hull(const EllipseIntervals& a, const EllipseIntervals& b) {
  EllipseIntervals both{joined(a.size, b.size), joined(a.shape, b.shape), kNone, joined(a.curl, b.curl)};
  if (std::isfinite(a.orientation.low) && std::isfinite(b.orientation.low))
    both.orientation = joined(a.orientation, beside(a.orientation, b.orientation));
  return both;
}

}  // namespace tonus::impedance
