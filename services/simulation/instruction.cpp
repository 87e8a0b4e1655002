#include "services/simulation/instruction.hpp"

#include <charconv>
#include <cmath>
#include <numbers>

#include "services/mechanics/two_link_dynamics.hpp"

namespace tonus::simulation {
namespace {

constexpr std::string_view kAlong = "stiffen_";

/// (factor - 1) (u' Z u) u u' at the hand, at the joints.
Eigen::Matrix2d grown(const Eigen::Matrix2d& joint, const Eigen::Matrix2d& jacobian, const Eigen::Vector2d& u,
                      double factor) {
  const Eigen::Matrix2d inverse = control::inverse(jacobian);
  const Eigen::Matrix2d hand = inverse.transpose() * joint * inverse;
  const Eigen::Matrix2d added = (factor - 1.0) * u.dot(hand * u) * (u * u.transpose());
  return jacobian.transpose() * added * jacobian;
}

}  // namespace

Instruction instruction_named(std::string_view name) noexcept {
  if (name == "relax") return {Instruction::Kind::kRelax, 0.0};
  if (name == "stiffen") return {Instruction::Kind::kStiffen, 0.0};
  if (!name.starts_with(kAlong)) return {};
  name.remove_prefix(kAlong.size());
  if (name == "x") return {Instruction::Kind::kStiffenAlong, 0.0};
  if (name == "y") return {Instruction::Kind::kStiffenAlong, std::numbers::pi / 2.0};
  int degrees = 0;
  const auto read = std::from_chars(name.data(), name.data() + name.size(), degrees);
  if (read.ec != std::errc() || read.ptr != name.data() + name.size()) return {};
  return {Instruction::Kind::kStiffenAlong, degrees * std::numbers::pi / 180.0};
}

AddedImpedance added_impedance(const SubjectProfile& subject, const Instruction& instruction,
                               const Eigen::Vector2d& angles) noexcept {
  const InstructionEffect& effect = subject.instruction;
  AddedImpedance added;
  if (!effect.is_on) return added;
  const Eigen::Matrix2d stiffness = subject.stiffness.matrix();
  const Eigen::Matrix2d damping = subject.damping.matrix();
  const double root = std::sqrt(effect.stiffened);
  switch (instruction.kind) {
    case Instruction::Kind::kNone:
      break;
    case Instruction::Kind::kRelax:
      added = {(effect.relaxed - 1.0) * stiffness, (effect.relaxed - 1.0) * damping};
      break;
    case Instruction::Kind::kStiffen:
      added = {(effect.stiffened - 1.0) * stiffness, (root - 1.0) * damping};
      break;
    case Instruction::Kind::kStiffenAlong: {
      const Eigen::Vector2d u(std::cos(instruction.direction), std::sin(instruction.direction));
      const Eigen::Matrix2d jacobian = subject.links.jacobian(angles);
      added = {grown(stiffness, jacobian, u, effect.stiffened), grown(damping, jacobian, u, root)};
      break;
    }
  }
  return added;
}

}  // namespace tonus::simulation
