#include "services/protocol/plan.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "services/contract/rig.hpp"
#include "services/contract/trial.hpp"
#include "services/protocol/directions.hpp"
#include "services/protocol/draws.hpp"
#include "services/protocol/rig_facts.hpp"

namespace tonus::protocol {
namespace {

constexpr std::uint64_t kRepeatStream = 1ULL << 32;
constexpr std::uint64_t kPlaceStream = 1ULL << 33;
constexpr std::uint64_t kForceStream = 1ULL << 34;
constexpr std::uint64_t kDirectionStream = 1ULL << 35;
constexpr std::uint64_t kConditionStreams = 1ULL << 16;

std::array<double, 2> pair(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }

/// Everything of a trial that is drawn for it alone, in a fixed order.
void draw_times(const Protocol& protocol, bool has_bias, Draws& draws, v1::TrialProgram& program) {
  const auto drawn = [&draws](const Span& span) { return draws.uniform(span.low, span.high); };
  program.wait_s(drawn(protocol.perturbation.wait));
  program.hold_s(drawn(protocol.perturbation.hold));
  if (!has_bias) return;
  program.bias_ramp_s(drawn(protocol.bias->ramp));
  program.bias_hold_s(drawn(protocol.bias->hold));
}

void append(Plan& plan, v1::TrialProgram program) {
  const auto index = static_cast<std::uint32_t>(plan.trials.size());
  program.planned_index(index);
  const double duration = expected_duration(program);
  plan.blocks.back().order.push_back(index);
  plan.trials.push_back({std::move(program), static_cast<std::uint32_t>(plan.blocks.size() - 1), duration});
}

double direction_deg(const Perturbation& p, std::size_t direction) {
  const double deg =
      std::fmod(p.first_direction + 360.0 * static_cast<double>(direction) / p.directions, 360.0);
  return deg < 0.0 ? deg + 360.0 : deg;
}

/// Directions of a set by their numbers. `counts`: of the condition so far.
std::vector<std::size_t> directions_of(const Protocol& protocol, std::uint64_t seed, const Plan& plan,
                                       std::vector<int>& counts, Draws& draws) {
  const Perturbation& p = protocol.perturbation;
  std::vector<std::size_t> directions;
  for (int repeat = 0; repeat < p.repeats; ++repeat) {
    for (int k = 0; k < p.directions; ++k) directions.push_back(static_cast<std::size_t>(k));
  }
  if (!protocol.stop_when) {
    draws.shuffle(directions);
    return directions;
  }
  const auto most = static_cast<std::size_t>(protocol.stop_when->trials_most);
  const std::size_t planned = plan.conditions.back().trials;
  directions.resize(std::min(directions.size(), most - std::min(most, planned)));
  const auto condition = static_cast<std::uint32_t>(plan.conditions.size() - 1);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    directions[i] =
        drawn_direction(protocol, seed, condition, static_cast<std::uint32_t>(planned + i), counts);
    ++counts[directions[i]];
  }
  return directions;
}

/// The condition that a set belongs to: a new one, or that of the set before.
void find_condition(const Protocol& protocol, const Block& block, Plan& plan, std::vector<int>& counts) {
  const bool is_new = protocol.bias || plan.conditions.empty() ||
                      plan.conditions.back().posture_index != block.posture_index ||
                      plan.conditions.back().instruction_index != block.instruction_index;
  if (!is_new) return;
  plan.conditions.push_back(
      {block.posture_index, block.instruction_index, protocol.bias ? block.set_number : 0, 0});
  counts.assign(static_cast<std::size_t>(protocol.perturbation.directions), 0);
}

void append_set(const Protocol& protocol, std::uint64_t seed, Block block, Plan& plan,
                std::vector<int>& counts) {
  const Perturbation& p = protocol.perturbation;
  // The contractions draw nothing: with them the other trials are the same as without.
  const std::size_t contractions = protocol.muscles.reference.trials > 0 ? 1 : 0;
  const auto stream = static_cast<std::uint64_t>(plan.blocks.size() - contractions) + 1;
  Draws draws(seed, stream);
  find_condition(protocol, block, plan, counts);
  const auto directions = directions_of(protocol, seed, plan, counts, draws);
  if (directions.empty()) return;
  block.condition = static_cast<std::uint32_t>(plan.conditions.size() - 1);
  plan.conditions.back().trials += static_cast<std::uint32_t>(directions.size());
  const bool has_bias = block.axis != BiasAxis::kNone;
  if (has_bias) {
    block.bias_force =
        Draws(seed, kForceStream + stream).uniform(protocol.bias->force.low, protocol.bias->force.high);
  }
  plan.blocks.push_back(block);
  const Posture& posture = protocol.postures[block.posture_index];
  for (const std::size_t k : directions) {
    v1::TrialProgram program =
        contract::new_program(v1::TRIAL_PERTURBATION, {posture.name, block.posture_index, posture.position});
    program.shoulder_angle_rad(protocol.shoulder_angle);
    program.set_number(block.set_number);
    program.instruction(protocol.instructions[block.instruction_index].name);
    program.direction_deg(direction_deg(p, k));
    program.amplitude_m(p.amplitude_of(block.set_number));
    program.rise_time_s(p.rise_time);
    if (has_bias) program.bias_threshold_N(protocol.bias->threshold);
    draw_times(protocol, has_bias, draws, program);
    append(plan, std::move(program));
  }
}

/// The subject contracts at the first posture, told by the program's kind.
void append_contractions(const Protocol& protocol, Plan& plan) {
  const ReferenceContraction& reference = protocol.muscles.reference;
  if (reference.trials == 0 || protocol.postures.empty()) return;
  Block block;
  block.set_number = 0;
  plan.blocks.push_back(block);
  const Posture& posture = protocol.postures.front();
  for (int i = 0; i < reference.trials; ++i) {
    v1::TrialProgram program =
        contract::new_program(v1::TRIAL_CONTRACTION, {posture.name, 0, posture.position});
    program.shoulder_angle_rad(protocol.shoulder_angle);
    program.set_number(0);
    program.instruction("contract");
    program.wait_s(protocol.perturbation.wait.low);
    program.hold_s(reference.duration);
    append(plan, std::move(program));
  }
}

void append_recording(const Recording& recording, std::uint32_t index, Plan& plan) {
  Block block;
  block.posture_index = index;
  block.condition = index;
  plan.conditions.push_back(
      {index, 0, 0, static_cast<std::uint32_t>(recording.is_whole ? 1 : recording.event_count)});
  plan.blocks.push_back(block);
  v1::TrialProgram program =
      contract::new_program(v1::TRIAL_PERTURBATION, {recording.name, index, recording.position});
  contract::put_shoulder({recording.shoulder, recording.shoulder_angle}, program);
  program.instruction(recording.instruction);
  program.recording_index(static_cast<std::int32_t>(index));
  if (recording.is_whole) {
    program.kind(v1::TRIAL_RECORDING);
    program.hold_s(recording.duration);
    append(plan, std::move(program));
    return;
  }
  for (int e = 0; e < recording.event_count; ++e) {
    program.recording_event(e);
    if (!recording.events.empty()) {
      const RecordedEvent& event = recording.events[static_cast<std::size_t>(e)];
      program.set_number(event.set);
      program.direction_deg(event.direction);
      program.amplitude_m(event.amplitude);
      program.rise_time_s(event.rise_time);
      program.hold_s(event.hold);
      program.bias_N(pair(event.bias));
    }
    append(plan, program);
  }
}

}  // namespace

double expected_duration(const v1::TrialProgram& program) {
  if (program.recording_index() >= 0) return program.hold_s();
  return kCentringTime + program.wait_s() + program.bias_ramp_s() + program.bias_hold_s() + program.hold_s() +
         kReturningTime;
}

Plan build_plan(const Protocol& protocol, std::uint64_t seed) {
  Plan plan;
  for (std::size_t r = 0; r < protocol.recordings.size(); ++r) {
    append_recording(protocol.recordings[r], static_cast<std::uint32_t>(r), plan);
  }
  append_contractions(protocol, plan);
  std::vector<int> counts;
  for (std::size_t p = 0; p < protocol.postures.size(); ++p) {
    for (std::size_t i = 0; i < protocol.instructions.size(); ++i) {
      for (int set = 1; set <= protocol.perturbation.sets; ++set) {
        Block block;
        block.posture_index = static_cast<std::uint32_t>(p);
        block.instruction_index = static_cast<std::uint32_t>(i);
        block.set_number = set;
        if (protocol.bias) block.axis = protocol.bias->axes[static_cast<std::size_t>(set - 1)];
        append_set(protocol, seed, block, plan, counts);
      }
    }
  }
  for (const PlannedTrial& trial : plan.trials) {
    if (trial.program.posture_index() == plan.postures.size()) {
      v1::PlannedPosture posture;
      posture.name(trial.program.posture());
      posture.position_m(trial.program.posture_m());
      plan.postures.push_back(posture);
    }
    auto& posture = plan.postures[trial.program.posture_index()];
    posture.trials(posture.trials() + 1);
  }
  return plan;
}

void bind_rig(Plan& plan, const Protocol& protocol, const Id& rig_id, const Eigen::Vector2d& home) {
  for (PlannedTrial& trial : plan.trials) {
    trial.program.rig_id(rig_id);
    if (protocol.kind == ProtocolKind::kRecording) continue;
    const auto& position = trial.program.posture_m();
    trial.program.shoulder_origin_m(
        pair(shoulder_origin(home, trial.program.shoulder_angle_rad(), {position[0], position[1]})));
  }
}

Eigen::Vector2d bias_force(BiasAxis axis, double force, const BiasAxes& axes) {
  switch (axis) {
    case BiasAxis::kNone:
      return Eigen::Vector2d::Zero();
    case BiasAxis::kMajorPlus:
      return force * axes.major;
    case BiasAxis::kMajorMinus:
      return -force * axes.major;
    case BiasAxis::kMinorPlus:
      return force * axes.minor;
    case BiasAxis::kMinorMinus:
      return -force * axes.minor;
  }
  return Eigen::Vector2d::Zero();
}

v1::TrialProgram commanded_program(const Protocol& protocol, const Plan& plan, std::uint32_t planned_index,
                                   const Id& session_id, std::uint32_t attempt, std::uint64_t seed,
                                   bool has_run_before, const std::optional<BiasAxes>& axes) {
  const PlannedTrial& planned = plan.trials[planned_index];
  const Block& block = plan.blocks[planned.block];
  v1::TrialProgram program = planned.program;
  program.session_id(session_id);
  program.attempt(attempt);
  const bool has_bias = block.axis != BiasAxis::kNone;
  if (has_bias && axes) program.bias_N(pair(bias_force(block.axis, block.bias_force, *axes)));
  const bool is_drawn = program.kind() == v1::TRIAL_PERTURBATION && protocol.kind != ProtocolKind::kRecording;
  if (has_run_before && is_drawn) {
    Draws draws(seed, kRepeatStream + attempt);
    draw_times(protocol, has_bias, draws, program);
  }
  return program;
}

std::size_t drawn_direction(const Protocol& protocol, std::uint64_t seed, std::uint32_t condition,
                            std::uint32_t number, std::span<const int> counts) {
  Draws draws(seed, kDirectionStream + kConditionStreams * condition + number);
  return draw_by(direction_chances(counts, protocol.stop_when->entropy), draws);
}

void steer(const Protocol& protocol, std::size_t direction, const Drive& drive, v1::TrialProgram& program) {
  program.direction_deg(direction_deg(protocol.perturbation, direction));
  program.amplitude_m(drive.amplitude);
  program.rise_time_s(drive.rise_time);
}

std::size_t direction_of(const Protocol& protocol, const v1::TrialProgram& program) {
  const Perturbation& p = protocol.perturbation;
  const double steps = std::round((program.direction_deg() - p.first_direction) * p.directions / 360.0);
  const double wrapped = std::fmod(steps, p.directions);
  return static_cast<std::size_t>(wrapped < 0.0 ? wrapped + p.directions : wrapped);
}

std::uint32_t requeue_place(std::uint64_t seed, std::uint32_t attempt, std::size_t remaining) {
  return static_cast<std::uint32_t>(Draws(seed, kPlaceStream + attempt).below(remaining + 1));
}

}  // namespace tonus::protocol
