#include "rig_agent/control/uncounted_way.hpp"

#include <algorithm>
#include <cmath>

namespace tonus::control {
namespace {

constexpr double kLimitShare = 0.15;      // of SafetyLimits::unexplained_torque
constexpr double kFrictionAllowed = 3.0;  // times the model's, which is known to a factor of two
constexpr double kLoadError = 0.15;       // of the load: gains of the force sensor and of the motors
constexpr double kWay = 0.012;            // rad; 8 mm at the end of both links
constexpr double kCounts = 4.0;           // of a coarse encoder
constexpr double kModelError = 0.33;      // of the inertia that couples the joints

}  // namespace

UncountedWay::UncountedWay(const SafetyLimits& limits, const JointFriction& friction,
                           const RigGeometry& geometry, double period) noexcept
    : period_(period),
      allowed_(kLimitShare * limits.unexplained_torque),
      friction_(kFrictionAllowed * friction.coulomb),
      radians_per_count_(1.0 / std::abs(geometry.counts_per_unit[0]),
                         1.0 / std::abs(geometry.counts_per_unit[1])) {}

void UncountedWay::begin_trial(const std::array<double, 2>& counts) noexcept {
  for (std::size_t i = 0; i < 2; ++i) {
    joints_[i] = Joint{};
    joints_[i].count = counts[i];
    joints_[i].lowest = joints_[i].highest = counts[1 - i];
  }
}

bool UncountedWay::check(const std::array<double, 2>& counts, const Eigen::Vector2d& unexplained,
                         const Eigen::Vector2d& load, const Eigen::Vector2d& inertia) noexcept {
  bool is_found = false;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    Joint& joint = joints_[i];
    const double other = counts[1 - i];
    const double allowed = allowed_ + friction_[k] + kLoadError * std::abs(load[k]);
    const bool turns = std::abs(unexplained[k]) > allowed;
    if (counts[i] != joint.count || !turns || unexplained[k] * joint.torque < 0.0) {
      joint = Joint{};
      joint.count = counts[i];
      joint.lowest = joint.highest = other;
    }
    if (!turns) continue;
    joint.torque = unexplained[k];
    joint.rate += period_ * (std::abs(unexplained[k]) - allowed) / inertia[k];
    joint.way += period_ * joint.rate;
    joint.lowest = std::min(joint.lowest, other);
    joint.highest = std::max(joint.highest, other);
    const double way = std::max(kWay, kCounts * radians_per_count_[k]) + kModelError * turned_meanwhile(i);
    is_found = is_found || joint.way > way;
  }
  return is_found;
}

double UncountedWay::turned_meanwhile(std::size_t joint) const noexcept {
  return (joints_[joint].highest - joints_[joint].lowest) *
         radians_per_count_[static_cast<Eigen::Index>(1 - joint)];
}

}  // namespace tonus::control
