#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "analysis_service/identification/measured_trial.hpp"
#include "analysis_service/impedance/options.hpp"
#include "services/core/id.hpp"

namespace tonus::identification {

/// What is identified together: one posture of a session, with one bias force and one instruction to the
/// subject.
struct Condition {
  Id session{};
  Id rig{};
  std::uint32_t posture_index = 0;
  std::string posture;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m, in S; not part of what makes a condition.
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();      ///< N, in S, on the arm.
  std::int32_t set = 0;                                ///< 0: all sets together.
  std::string instruction;

  [[nodiscard]] bool is_loaded() const { return bias != Eigen::Vector2d::Zero(); }
};

/// By session, posture, bias, set, instruction.
[[nodiscard]] bool operator<(const Condition& a, const Condition& b);

/// The condition that a trial counts for: without bias all sets together, with bias the trial's own set.
[[nodiscard]] Condition condition_of(const TrialPlan& plan);

/// The trial's own set alone. Sessions with loaded sets also want the unloaded ones one by one: the first
/// gives the bias directions, the first and the last the stiffness that predicts the spring centres (method,
/// section 8).
[[nodiscard]] Condition set_condition_of(const TrialPlan& plan);

/// id_of "session/posture index/set:bias/instruction/method/model", the session in hexadecimal, the bias in N
/// with three decimals: the same for the same condition after any restart.
[[nodiscard]] Id estimate_id(const Condition& condition, impedance::Method method, impedance::Model model);

}  // namespace tonus::identification
