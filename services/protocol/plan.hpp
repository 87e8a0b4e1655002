#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "services/core/id.hpp"
#include "services/protocol/protocol.hpp"

#include <idl/session.h>
#include <idl/trial.h>

namespace tonus::protocol {

/// A trial as planned. Its program lacks what only the session knows: session, rig, attempt, and a bias along
/// axes that have to be measured first.
struct PlannedTrial {
  v1::TrialProgram program;
  std::uint32_t block = 0;
  double duration = 0.0;  ///< s, expected.
};

/// Of trials that are identified with no others: reference contractions.
inline constexpr std::uint32_t kNoCondition = std::numeric_limits<std::uint32_t>::max();

/// Trials that are interchangeable in their order: a set at a posture under one instruction. A rejected trial
/// is queued again within its block.
struct Block {
  std::uint32_t posture_index = 0;
  std::uint32_t instruction_index = 0;  ///< In Protocol::instructions.
  std::int32_t set_number = 1;
  std::uint32_t condition = kNoCondition;  ///< In Plan::conditions.
  BiasAxis axis = BiasAxis::kNone;
  double bias_force = 0.0;           ///< N, along the axis.
  std::vector<std::uint32_t> order;  ///< planned_index of its trials.
};

/// What is identified together: the sets of a posture under one instruction; in a loaded protocol each set.
struct PlannedCondition {
  std::uint32_t posture_index = 0;
  std::uint32_t instruction_index = 0;
  std::int32_t set_number = 0;  ///< 0: all sets.
  std::uint32_t trials = 0;     ///< The most.
};

struct Plan {
  std::vector<PlannedTrial> trials;          ///< By planned_index, which is the order of the plan.
  std::vector<Block> blocks;                 ///< In the order of their running.
  std::vector<PlannedCondition> conditions;  ///< In the order of their running.
  std::vector<v1::PlannedPosture> postures;
};

/// Expected parts of a trial that no protocol states, for estimates of time only.
inline constexpr double kCentringTime = 1.0;   ///< s
inline constexpr double kReturningTime = 1.0;  ///< s

/// Posture after posture, instruction after instruction, set after set; within a set each direction `repeats`
/// times in random order. Recordings come one after the other, their events in the order of the record. The
/// same protocol and seed give the same plan on every machine (Draws; stream b + 1 for block b).
///
/// With `stop_when` a condition has at most its `trials_most`, and its directions are those of
/// drawn_direction(), as they come if no trial is rejected; the session draws them anew as it goes.
[[nodiscard]] Plan build_plan(const Protocol& protocol, std::uint64_t seed);

/// Says which rig runs it and where its handle's home is (m, in R): each posture's shoulder origin follows.
/// The pose of a recording is the recording's own.
void bind_rig(Plan& plan, const Protocol& protocol, const Id& rig_id, const Eigen::Vector2d& home);

/// Axes of a stiffness ellipse: unit vectors in S. Plus is the sense with an angle in (-90, 90] deg.
struct BiasAxes {
  Eigen::Vector2d major = Eigen::Vector2d::UnitX();
  Eigen::Vector2d minor = Eigen::Vector2d::UnitY();
};

/// Force on the arm, N.
[[nodiscard]] Eigen::Vector2d bias_force(BiasAxis axis, double force, const BiasAxes& axes);

/// What is sent for a planned trial. A repeat of it (has_run_before) draws its times anew, from stream 2^32 +
/// attempt, so that its onset is as unforeseeable as the first time.
[[nodiscard]] v1::TrialProgram commanded_program(const Protocol& protocol, const Plan& plan,
                                                 std::uint32_t planned_index, const Id& session_id,
                                                 std::uint32_t attempt, std::uint64_t seed,
                                                 bool has_run_before, const std::optional<BiasAxes>& axes);

/// Direction, 0 .. directions - 1, of the condition's `number`th command (from 0) in a protocol with
/// `stop_when`: by the chances of direction_chances(), from stream 2^35 + 2^16 condition + number. `counts`:
/// trials of each direction that count.
[[nodiscard]] std::size_t drawn_direction(const Protocol& protocol, std::uint64_t seed,
                                          std::uint32_t condition, std::uint32_t number,
                                          std::span<const int> counts);

/// Gives a program its direction and drive.
void steer(const Protocol& protocol, std::size_t direction, const Drive& drive, v1::TrialProgram& program);

/// The direction of a program, 0 .. directions - 1.
[[nodiscard]] std::size_t direction_of(const Protocol& protocol, const v1::TrialProgram& program);

/// Place for a rejected trial among `remaining` trials of its block: 0 .. remaining, from stream 2^33 +
/// attempt.
[[nodiscard]] std::uint32_t requeue_place(std::uint64_t seed, std::uint32_t attempt, std::size_t remaining);

/// s, from the command to the outcome.
[[nodiscard]] double expected_duration(const v1::TrialProgram& program);

}  // namespace tonus::protocol
