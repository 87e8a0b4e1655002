#include "analysis_service/identification/motion.hpp"

#include <algorithm>
#include <limits>

namespace tonus::identification {

Eigen::Vector2d mean_velocity(std::span<const Eigen::Vector2d> positions, double sample_period) {
  if (positions.size() < 2) return Eigen::Vector2d::Zero();
  const double centre = 0.5 * static_cast<double>(positions.size() - 1);
  Eigen::Vector2d numerator = Eigen::Vector2d::Zero();
  double denominator = 0.0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double t = (static_cast<double>(i) - centre) * sample_period;
    numerator += t * (positions[i] - positions[0]);
    denominator += t * t;
  }
  return numerator / denominator;
}

double largest_speed(std::span<const Eigen::Vector2d> positions, std::size_t window, double sample_period) {
  window = std::clamp<std::size_t>(window, 2, std::max<std::size_t>(positions.size(), 2));
  double largest = 0.0;
  for (std::size_t first = 0; first + window <= positions.size(); ++first) {
    largest = std::max(largest, mean_velocity(positions.subspan(first, window), sample_period).norm());
  }
  return largest;
}

DistanceRange mean_distances(std::span<const Eigen::Vector2d> values, std::size_t window,
                             const Eigen::Vector2d& centre) {
  if (values.empty()) return {};
  window = std::clamp<std::size_t>(window, 1, values.size());
  DistanceRange range{std::numeric_limits<double>::infinity(), 0.0};
  for (std::size_t first = 0; first + window <= values.size(); ++first) {
    const double distance = (mean(values.subspan(first, window)) - centre).norm();
    range.smallest = std::min(range.smallest, distance);
    range.largest = std::max(range.largest, distance);
  }
  return range;
}

Eigen::Vector2d mean(std::span<const Eigen::Vector2d> values) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto& value : values) sum += value;
  return values.empty() ? sum : Eigen::Vector2d(sum / static_cast<double>(values.size()));
}

}  // namespace tonus::identification
