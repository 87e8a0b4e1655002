#include "rig_agent/in_process/measure.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <spdlog/fmt/fmt.h>

#include "rig_agent/control/fault_text.hpp"
#include "rig_agent/control/rig_loop.hpp"
#include "rig_agent/control/validation.hpp"
#include "rig_agent/drivers/simulated.hpp"

namespace tonus::simulated {
namespace {

constexpr int kDirections = 8;

/// The loop and its driver, and every sample that it took.
class Rig {
 public:
  static Result<std::unique_ptr<Rig>> create(const simulation::Profile& profile) {
    auto rig = std::unique_ptr<Rig>(new Rig(profile));
    const control::LoopConfig config = simulation::loop_config(profile);
    if (auto done = rig->driver_.configure(1.0 / config.rate); !done) return done.error();
    if (auto done = rig->driver_.activate(); !done) return done.error();
    auto loop = control::RigLoop::create(rig->driver_, config);
    if (!loop) return loop.error();
    rig->loop_ = std::move(*loop);
    rig->period_ns_ = std::llround(1e9 / config.rate);
    return rig;
  }

  Result<control::TrialResult> run(const control::TrialProgram& program) {
    if (auto valid = control::validate(program, loop_->config().limits); !valid) return valid.error();
    control::Command command;
    command.request = program.number;
    command.kind = control::CommandKind::kStartTrial;
    command.program = program;
    if (!loop_->post(command)) return fail(ErrorCode::kUnavailable, "the loop takes no command");
    const double longest = program.centring_timeout + program.wait + program.hold + program.return_time + 5.0;
    control::TrialResult result;
    for (double t = 0.0; t < longest; t += loop_->period()) {
      step();
      if (!loop_->next_result(result)) continue;
      if (result.outcome == control::TrialOutcome::kCompleted) return result;
      return fail(ErrorCode::kUnavailable,
                  fmt::format("trial {}: {}{}", program.number, control::outcome_name(result.outcome),
                              result.faults == 0 ? "" : ": " + control::fault_text(result.faults)));
    }
    return fail(ErrorCode::kTimeout, fmt::format("trial {}: no end after {} s", program.number, longest));
  }

  [[nodiscard]] const std::vector<control::SampleRecord>& samples() const { return samples_; }

 private:
  explicit Rig(const simulation::Profile& profile) : driver_(profile) {}

  void step() {
    loop_->keep_alive();
    loop_->step(now_ns_ += period_ns_);
    control::SampleRecord sample;
    while (loop_->next_sample(sample)) samples_.push_back(sample);
    control::CommandReply reply;
    while (loop_->next_reply(reply)) {
    }
  }

  drivers::Simulated driver_;
  std::unique_ptr<control::RigLoop> loop_;
  std::int64_t period_ns_ = 0;
  std::int64_t now_ns_ = 0;
  std::vector<control::SampleRecord> samples_;
};

control::TrialProgram program_of(const Procedure& procedure, const Posture& posture,
                                 const ShoulderPose& shoulder, int number, int trials) {
  control::TrialProgram program;
  program.number = static_cast<std::uint64_t>(number);
  program.posture = posture.position;
  program.shoulder = shoulder;
  program.centring_time = procedure.centring_time;
  const double share = trials > 1 ? static_cast<double>((7 * (number - 1)) % trials) / (trials - 1) : 0.0;
  program.wait = procedure.shortest_wait + share * (procedure.longest_wait - procedure.shortest_wait);
  program.direction = 2.0 * std::numbers::pi * ((number - 1) % kDirections) / kDirections;
  program.amplitude = procedure.amplitude;
  program.rise_time = procedure.rise_time;
  program.hold = procedure.hold;
  return program;
}

}  // namespace

const std::vector<Posture>& published_postures() {
  static const std::vector<Posture> postures = {{"reference", {0.0, 0.38}},
                                                {"distal", {0.0, 0.52}},
                                                {"proximal", {0.0, 0.24}},
                                                {"right", {0.295, 0.38}},
                                                {"left", {-0.295, 0.38}}};
  return postures;
}

Result<recording::Recording> measure(const simulation::Profile& profile, const Posture& posture,
                                     const Procedure& procedure, std::int64_t first_trial) {
  auto rig = Rig::create(profile);
  if (!rig) return rig.error();
  recording::Recording record;
  record.participant.id = "sub-01";
  record.participant.upper_arm_m = profile.subject.links.l1;
  record.participant.forearm_m = profile.subject.links.l2;
  record.task = "unloaded";
  record.acquisition = posture.name;
  record.posture = posture.name;
  record.posture_position = posture.position;
  record.sampling_frequency = profile.loop_rate / profile.sample_divider;
  record.is_raw = true;
  record.rig = simulation::rig_geometry(profile);
  record.shoulder = control::shoulder_for(profile.manipulandum.home, posture.position);

  const int trials = kDirections * procedure.sets;
  std::uint64_t first_sequence = 0;
  for (int number = 1; number <= trials; ++number) {
    const auto program = program_of(procedure, posture, record.shoulder, number, trials);
    const auto result = (*rig)->run(program);
    if (!result) return result.error();
    if (number == 1) first_sequence = result->first_sequence;
    recording::PerturbationEvent event;
    event.onset_s = static_cast<double>(result->onset_sequence - first_sequence) / record.sampling_frequency;
    event.duration_s = procedure.hold;
    event.trial = first_trial + number - 1;
    event.set = (number - 1) / kDirections + 1;
    event.direction_deg = program.direction * 180.0 / std::numbers::pi;
    event.amplitude_m = procedure.amplitude;
    event.rise_time_s = procedure.rise_time;
    record.events.push_back(event);
  }
  for (const control::SampleRecord& sample : (*rig)->samples()) {
    if (sample.sequence < first_sequence) continue;
    recording::Row row;
    row.raw = sample.raw;
    row.raw.acquisition_ns = recording::row_time_ns(record, record.rows.size());
    record.rows.push_back(row);
    record.commanded.push_back(sample.commanded);
  }
  return record;
}

}  // namespace tonus::simulated
