#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "services/core/id.hpp"
#include "services/core/result.hpp"
#include "services/mechanics/rig_geometry.hpp"
#include "services/protocol/protocol.hpp"

#include <idl/rig.h>

namespace tonus::protocol {

/// What the rig's loop stops at: a protocol stays within, by the same rules as the rig's own check of a
/// trial.
struct StopsAt {
  Eigen::Vector2d workspace_centre = Eigen::Vector2d::Zero();  ///< m, in R.
  double workspace_radius = 0.0;                               ///< m
  double force = 0.0;                                          ///< N, measured at the handle.
};

inline constexpr double kBiasShare =
    0.5;  ///< Of the force at which the rig stops, the most that a bias may be.

/// What a protocol has to respect of the rig that runs it.
struct RigFacts {
  Id rig_id = kNoId;
  std::string name = "rig";
  RigKind kind = RigKind::kTwoLink;
  TwoLink links{0.30, 0.35};                          ///< m
  Eigen::Vector2d home = Eigen::Vector2d(0.0, 0.45);  ///< m, handle's home in R.
  double margin = 0.02;             ///< m, from the handle to the limits of its workspace, least allowed.
  double force_limit = 44.5;        ///< N, full scale of the force sensor in its worst direction.
  std::optional<StopsAt> stops_at;  ///< Absent: the rig moves nobody, or does not say.
};

/// The facts of a description. The force limit is the smallest singular value of the calibration times the
/// voltage of saturation. kInvalidArgument where the lengths or the home make no sense.
[[nodiscard]] Result<RigFacts> facts_of(const v1::RigDescription& description);

/// Origin of S in R (m) that puts the handle's home at `position` in S: home - Rot(angle) position.
[[nodiscard]] Eigen::Vector2d shoulder_origin(const Eigen::Vector2d& home, double angle,
                                              const Eigen::Vector2d& position);

/// How far a protocol takes the rig. Excursions reach about twice the commanded amplitude (published: 5 mm
/// commanded, up to 10 mm seen), and the force beyond the bias is bounded with a stiffness of kStiffestArm.
struct Extremes {
  double nearest = 0.0;   ///< m from the robot's base, two-link rigs.
  double farthest = 0.0;  ///< m
  double nearest_allowed = 0.0;
  double farthest_allowed = 0.0;
  double bias = 0.0;                 ///< N, largest bias force.
  double force = 0.0;                ///< N, largest force to expect.
  double force_allowed = 0.0;        ///< N, the sensor's full scale or the force at which the rig stops.
  double bias_allowed = 0.0;         ///< N
  double from_centre = 0.0;          ///< m from the workspace's centre; where the rig says at what it stops.
  double from_centre_allowed = 0.0;  ///< m
};

inline constexpr double kExcursionOverAmplitude = 2.0;
inline constexpr double kStiffestArm = 1000.0;  ///< N/m; the largest published stiffness is well under it.

[[nodiscard]] Extremes extremes_of(const Protocol& protocol, const RigFacts& facts);

/// Refuses a protocol that this rig cannot run: out of its workspace, over its force limit, or with more
/// directions or bias than a one-axis rig has. A recording is accepted from any rig: what it may do was done
/// already.
[[nodiscard]] Result<void> check_against_rig(const Protocol& protocol, const RigFacts& facts);

}  // namespace tonus::protocol
