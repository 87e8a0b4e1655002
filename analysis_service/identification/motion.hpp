#pragma once

#include <Eigen/Core>
#include <span>

namespace tonus::identification {

/// Velocity over a window of n equally spaced positions (m), as the slope of the least-squares line,
///
///     v = sum_i t_i p_i / sum_i t_i^2,   t_i = (i - (n - 1)/2) h,
///
/// h the sample period (s), m/s. One encoder step d anywhere in the window reads as at most 1.5 d / (n h): a
/// difference of neighbours would read d / h. Zero for fewer than two positions. Pure, allocates nothing.
[[nodiscard]] Eigen::Vector2d mean_velocity(std::span<const Eigen::Vector2d> positions, double sample_period);

/// Largest |v| over all windows of `window` positions (over all of them where there are fewer).
[[nodiscard]] double largest_speed(std::span<const Eigen::Vector2d> positions, std::size_t window,
                                   double sample_period);

/// Smallest and largest distance from `centre` of the means over all windows of `window` values (over all
/// values where there are fewer). Both zero without values.
struct DistanceRange {
  double smallest = 0.0;
  double largest = 0.0;
};
[[nodiscard]] DistanceRange mean_distances(std::span<const Eigen::Vector2d> values, std::size_t window,
                                           const Eigen::Vector2d& centre);

/// Mean; zero without values.
[[nodiscard]] Eigen::Vector2d mean(std::span<const Eigen::Vector2d> values);

}  // namespace tonus::identification
