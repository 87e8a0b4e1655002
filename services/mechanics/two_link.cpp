#include "services/mechanics/two_link.hpp"

#include <algorithm>
#include <cmath>

namespace tonus {

Eigen::Vector2d TwoLink::endpoint(const Eigen::Vector2d& angles) const {
  const double t12 = angles[0] + angles[1];
  return {l1 * std::cos(angles[0]) + l2 * std::cos(t12), l1 * std::sin(angles[0]) + l2 * std::sin(t12)};
}

Eigen::Matrix2d TwoLink::jacobian(const Eigen::Vector2d& angles) const {
  const double t12 = angles[0] + angles[1];
  const double s1 = l1 * std::sin(angles[0]);
  const double c1 = l1 * std::cos(angles[0]);
  const double s12 = l2 * std::sin(t12);
  const double c12 = l2 * std::cos(t12);
  Eigen::Matrix2d j;
  j << -s1 - s12, -s12, c1 + c12, c12;
  return j;
}

Eigen::Matrix2d TwoLink::jacobian_rate(const Eigen::Vector2d& angles, const Eigen::Vector2d& rates) const {
  const double t12 = angles[0] + angles[1];
  const double w1 = rates[0];
  const double w12 = rates[0] + rates[1];
  const double s1 = l1 * std::sin(angles[0]) * w1;
  const double c1 = l1 * std::cos(angles[0]) * w1;
  const double s12 = l2 * std::sin(t12) * w12;
  const double c12 = l2 * std::cos(t12) * w12;
  Eigen::Matrix2d j_rate;
  j_rate << -c1 - c12, -c12, -s1 - s12, -s12;
  return j_rate;
}

Eigen::Vector2d TwoLink::angles_at(const Eigen::Vector2d& point) const {
  const double cos_t2 = (point.squaredNorm() - l1 * l1 - l2 * l2) / (2.0 * l1 * l2);
  const double t2 = std::acos(std::clamp(cos_t2, -1.0, 1.0));
  const double t1 = std::atan2(point.y(), point.x()) - std::atan2(l2 * std::sin(t2), l1 + l2 * std::cos(t2));
  return {t1, t2};
}

bool TwoLink::reaches(const Eigen::Vector2d& point) const {
  const double r = point.norm();
  return r > std::abs(l1 - l2) && r < l1 + l2;
}

}  // namespace tonus
