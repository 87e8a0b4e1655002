#include "services/simulation/muscles.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tonus::simulation {
namespace {

constexpr double kTwitch = 0.04;       // s, time constant of a muscle's force behind its activation.
constexpr double kSpindlePower = 0.3;  // Of a spindle's answer to the speed of stretch.
constexpr double kLeastRest = 0.25;    // Of the activation at rest, that no relaxing goes below.

/// Shoulder, elbow, two-joint.
Eigen::Vector3d groups_of(const JointImpedance& joints) {
  return {joints.shoulder, joints.elbow, joints.two_joint};
}

/// The groups of a symmetric joint matrix [[s + d, d], [d, e + d]].
Eigen::Vector3d groups_of(const Eigen::Matrix2d& m) {
  const double two_joint = 0.5 * (m(0, 1) + m(1, 0));
  return {m(0, 0) - two_joint, m(1, 1) - two_joint, two_joint};
}

/// Speeds with which the joints turn at each group, rad/s: flexion is positive and stretches the extensor.
Eigen::Vector3d turning(const Eigen::Vector2d& rates) { return {rates[0], rates[1], rates[0] + rates[1]}; }

double spindle(const MuscleProfile& muscles, double stretch) {
  const double above = stretch - muscles.reflex_threshold;
  return above > 0.0 ? muscles.reflex * std::pow(above, kSpindlePower) : 0.0;
}

}  // namespace

Eigen::Vector3d shared_torque(const Eigen::Vector2d& joint_torque, const JointImpedance& strength) noexcept {
  const Eigen::Vector3d weight = groups_of(strength).array().square().inverse();
  const double both = (joint_torque[0] * weight[0] + joint_torque[1] * weight[1]) / weight.sum();
  return {joint_torque[0] - both, joint_torque[1] - both, both};
}

Activations activations(const SubjectProfile& subject, const MuscleDemand& demand) noexcept {
  const MuscleProfile& muscles = subject.muscles;
  const double turns = 2.0 * std::numbers::pi * demand.tremor_frequency * kTwitch;
  const Eigen::Vector3d torque =
      shared_torque(demand.load + demand.push + (1.0 + turns * turns) * demand.tremor, muscles.strength);
  const Eigen::Vector3d strength = groups_of(muscles.strength);
  const Eigen::Vector3d own = groups_of(subject.stiffness);
  const Eigen::Vector3d now = groups_of(demand.stiffness);
  const Eigen::Vector3d rates = turning(demand.felt_rates);
  Activations active{};
  for (std::size_t pair = 0; pair < kMuscles / 2; ++pair) {
    const auto g = static_cast<Eigen::Index>(pair);
    const double ratio = own[g] > 0.0 ? now[g] / own[g] : 1.0;
    const double both =
        std::max(kLeastRest * muscles.rest, muscles.rest + muscles.per_stiffness * (ratio - 1.0));
    const double share = torque[g] / strength[g];
    active[2 * pair] = both + std::max(0.0, share) + spindle(muscles, -rates[g]);
    active[2 * pair + 1] = both + std::max(0.0, -share) + spindle(muscles, rates[g]);
  }
  for (double& a : active) a = std::min(a, 1.0);
  return active;
}

}  // namespace tonus::simulation
