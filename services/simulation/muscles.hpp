#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "services/simulation/subject_profile.hpp"

namespace tonus::simulation {

/// The three muscle groups of JointImpedance, each as a pair: flexors turn the joints counter-clockwise.
inline constexpr std::size_t kMuscles = 6;
inline constexpr std::array<const char*, kMuscles> kMuscleNames{"ShoulderFlexor", "ShoulderExtensor",
                                                                "ElbowFlexor",    "ElbowExtensor",
                                                                "TwoJointFlexor", "TwoJointExtensor"};

/// Activation of each muscle, 0 to 1, where 1 is as hard as the subject can.
using Activations = std::array<double, kMuscles>;

/// What the nerves ask of the muscles within one period. SI, joints in S.
struct MuscleDemand {
  Eigen::Matrix2d stiffness = Eigen::Matrix2d::Zero();  ///< Of the joints, as it is now, fatigue left out.
  Eigen::Vector2d load = Eigen::Vector2d::Zero();       ///< N m, held steadily.
  Eigen::Vector2d push = Eigen::Vector2d::Zero();       ///< N m, of slow voluntary forces.
  Eigen::Vector2d tremor = Eigen::Vector2d::Zero();     ///< N m.
  double tremor_frequency = 0.0;                        ///< Hz.
  Eigen::Vector2d felt_rates =
      Eigen::Vector2d::Zero();  ///< rad/s, of the reflex's delay ago; zero without reflex.
};

/// Torque of each group (shoulder, elbow, two-joint) that together give these joint torques (N m) with the
/// least sum of squared shares of the groups' strength: with t the two-joint group's,
///     t = (tau_1 / S_1^2 + tau_2 / S_2^2) / (1 / S_1^2 + 1 / S_2^2 + 1 / S_t^2),
/// shoulder tau_1 - t, elbow tau_2 - t.
[[nodiscard]] Eigen::Vector3d shared_torque(const Eigen::Vector2d& joint_torque,
                                            const JointImpedance& strength) noexcept;

/// Activations that meet the demand:
///
///     co-contraction  rest + per_stiffness (k - 1) in both of a pair, k the group's stiffness over the
///                     profile's; at least a quarter of rest
///     torque          |T| / strength in the one of the pair that pulls (shared_torque)
///     tremor          likewise, times 1 + (2 pi f T)^2, T = 40 ms: what a muscle's slow twitch takes away
///     reflex          reflex (v - threshold)^0.3 in a muscle that is stretched with v rad/s; the power is
///     that
///                     of muscle spindles (Houk, Rymer and Crago 1981)
///
/// Their sum, at most 1. REALTIME.
[[nodiscard]] Activations activations(const SubjectProfile& subject, const MuscleDemand& demand) noexcept;

}  // namespace tonus::simulation
