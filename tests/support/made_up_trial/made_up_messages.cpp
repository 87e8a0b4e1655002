#include "tests/support/made_up_trial/made_up_messages.hpp"

#include <utility>

#include "services/core/name.hpp"

namespace tonus::identification::testing {
namespace {

v1::TrialProgram program_of(const TrialPlan& plan) {
  v1::TrialProgram wire;
  wire.session_id(plan.session);
  wire.rig_id(plan.rig);
  wire.attempt(plan.attempt);
  wire.posture(plan.posture);
  wire.posture_m({plan.position[0], plan.position[1]});
  wire.shoulder_origin_m({plan.shoulder.origin[0], plan.shoulder.origin[1]});
  wire.shoulder_angle_rad(plan.shoulder.angle);
  wire.set_number(plan.set);
  return wire;
}

v1::RigSample sample_of(const Row& row) {
  v1::RigSample sample;
  sample.acquisition_ns(row.raw.acquisition_ns);
  sample.encoder_count(row.raw.encoder_count);
  sample.force_V(row.raw.force_V);
  sample.commanded_m(row.commanded);
  sample.phase(static_cast<std::uint8_t>(row.phase));  // the same order: wire_test
  return sample;
}

}  // namespace

MeasuredTrial as_of(MeasuredTrial trial, const std::string& rig, const Id& session) {
  TrialPlan& plan = trial.report.plan;
  plan.rig = rig_id(rig);
  plan.session = session;
  plan.trial = trial_id(session, plan.attempt);
  return trial;
}

v1::RigDescription description_of(const std::string& name) {
  const RigGeometry rig = made_up_rig();
  v1::RigDescription wire;
  wire.rig_id(rig_id(name));
  wire.name(name);
  wire.kind(v1::RIG_TWO_LINK);
  wire.link_lengths_m({rig.links.l1, rig.links.l2});
  wire.encoder_counts_per_unit(rig.counts_per_unit);
  wire.encoder_zero_count(rig.encoder_zero);
  wire.encoder_sign(rig.encoder_sign);
  const auto& c = rig.force_calibration;
  wire.force_calibration_N_per_V({c(0, 0), c(0, 1), c(1, 0), c(1, 1)});
  wire.force_offset_V({rig.force_offset_V[0], rig.force_offset_V[1]});
  wire.force_sensor_angle_rad(rig.force_sensor_angle);
  wire.force_saturation_V(rig.force_saturation_V);
  wire.sample_rate_Hz(kRate);
  wire.displacement_unit("m");
  wire.force_unit("N");
  return wire;
}

v1::SessionPlan plan_of(const std::string& rig, const Id& session, const std::string& started_at) {
  v1::SessionPlan plan;
  plan.session_id(session);
  plan.rig_id(rig_id(rig));
  plan.started_at(started_at);
  return plan;
}

v1::TrialCommand command_of(const MeasuredTrial& trial) {
  v1::TrialCommand wire;
  wire.trial_id(trial.report.plan.trial);
  wire.program(program_of(trial.report.plan));
  return wire;
}

std::vector<v1::SampleBlock> messages_of(const MeasuredTrial& trial, std::size_t rows_a_block) {
  std::vector<v1::SampleBlock> messages;
  for (const RowBlock& block : blocks_of(trial, rows_a_block)) {
    v1::SampleBlock wire;
    wire.rig_id(block.rig);
    wire.session_id(trial.report.plan.session);
    wire.trial_id(block.trial);
    wire.epoch(block.epoch);
    wire.first_sequence(block.first_sequence);
    for (const Row& row : block.rows) wire.samples().push_back(sample_of(row));
    messages.push_back(std::move(wire));
  }
  return messages;
}

v1::TrialOutcome outcome_of(const MeasuredTrial& trial) {
  v1::TrialOutcome wire;
  wire.trial_id(trial.report.plan.trial);
  wire.program(program_of(trial.report.plan));
  wire.epoch(trial.report.epoch);
  wire.first_sequence(trial.report.range.first);
  wire.onset_sequence(trial.report.onset);
  wire.last_sequence(trial.report.range.last());
  wire.sample_rate_Hz(trial.report.sample_rate);
  return wire;
}

}  // namespace tonus::identification::testing
