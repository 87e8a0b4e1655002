#pragma once

#include <optional>
#include <string>

#include "services/mechanics/rig_geometry.hpp"

#include <idl/estimate.h>
#include <idl/rig.h>

/// What the gateway makes of the bus's messages for Foxglove and Lichtblick: SI numbers in the shoulder
/// frame, and drawings. JSON; pure.
namespace tonus::dashboard {

/// Of the newest sample of a block:
/// {"sequence", "rig_clock_ns", "position_m": {"x", "y"}, "force_N": {"x", "y"}, "commanded_m": {"x", "y"},
///  "phase"}. The hand in S, and the force of the handle on the arm, in N; commanded is the displacement from
/// the posture, null where it is not known. None of an empty block.
[[nodiscard]] std::optional<std::string> hand_json(const v1::SampleBlock& block, const RigGeometry& geometry,
                                                   const ShoulderPose& shoulder);
extern const char kHandSchema[];

/// m of a drawn ellipse for each N/m of its matrix.
inline constexpr double kMetresPerStiffness = 2e-4;

/// The stiffness ellipse at its posture as foxglove.SceneUpdate, in the frame "shoulder": a closed line of
/// the restoring force for unit displacement in each direction, kMetresPerStiffness m for 1 N/m, and the
/// posture's name. The entity's id is the estimate's id. Of an estimate without an ellipse the entity is
/// deleted.
[[nodiscard]] std::string ellipse_scene_json(const v1::Estimate& estimate, std::uint64_t time_ns);
extern const char kSceneSchema[];

}  // namespace tonus::dashboard
