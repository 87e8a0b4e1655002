#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

#include "services/simulation/subject_profile.hpp"

namespace tonus::simulation {

/// What the simulated subject understands of an instruction's name in a protocol:
///
///     relax        stiffness and damping of all muscles times InstructionEffect::relaxed
///     stiffen      stiffness of all muscles times `stiffened`, damping times its root
///     stiffen_x    the same at the hand along x of S alone; stiffen_y; stiffen_30: 30 deg counter-clockwise
///     from x
///
/// He does not understand anything else, and holds still.
struct Instruction {
  enum class Kind : std::uint8_t { kNone, kRelax, kStiffen, kStiffenAlong };
  Kind kind = Kind::kNone;
  double direction = 0.0;  ///< rad in S, of kStiffenAlong.
};

/// REALTIME.
[[nodiscard]] Instruction instruction_named(std::string_view name) noexcept;

/// What the muscles add to the profile's joint stiffness (N m/rad) and damping (N m s/rad).
struct AddedImpedance {
  Eigen::Matrix2d stiffness = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d damping = Eigen::Matrix2d::Zero();
};

/// With the arm at these joint angles. Along a direction u the hand's stiffness k = u' K u grows to
/// `stiffened` k by (stiffened - 1) k u u' at the hand, J' (...) J at the joints; the damping likewise by the
/// root, which keeps the damping ratio. Zero where the effect is off. REALTIME.
[[nodiscard]] AddedImpedance added_impedance(const SubjectProfile& subject, const Instruction& instruction,
                                             const Eigen::Vector2d& angles) noexcept;

}  // namespace tonus::simulation
