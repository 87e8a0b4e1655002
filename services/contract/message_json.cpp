#include "services/contract/message_json.hpp"

#include <nlohmann/json.hpp>

#include "services/contract/estimate_json.hpp"
#include "services/contract/names.hpp"
#include "services/core/id.hpp"

namespace tonus::contract {

using nlohmann::json;

namespace {

const char* kind_name(v1::TrialKind kind) {
  switch (kind) {
    case v1::TRIAL_PERTURBATION:
      return "perturbation";
    case v1::TRIAL_RECORDING:
      return "recording";
    case v1::TRIAL_CONTRACTION:
      return "contraction";
  }
  return "unknown";
}

}  // namespace

json message_json(const v1::Estimate& estimate) {
  json object = json_of(estimate);
  object.update({{"estimate_id", to_hex(estimate.estimate_id())},
                 {"session_id", to_hex(estimate.session_id())},
                 {"rig_id", to_hex(estimate.rig_id())},
                 {"posture_index", estimate.posture_index()},
                 {"posture_m", estimate.posture_m()},
                 {"instruction", estimate.instruction()}});
  return object;
}

json message_json(const v1::TrialVerdict& verdict) {
  json reasons = json::array();
  for (const v1::VerdictReason reason : verdict.reasons()) reasons.push_back(v1::reason_name(reason));
  json muscles = json::array();
  for (const v1::MuscleActivity& muscle : verdict.muscles()) {
    muscles.push_back({{"channel", muscle.channel()},
                       {"is_normalised", muscle.is_normalised()},
                       {"before_onset", muscle.before_onset()},
                       {"short_latency", muscle.short_latency()},
                       {"long_latency", muscle.long_latency()}});
  }
  return {{"trial_id", to_hex(verdict.trial_id())},
          {"session_id", to_hex(verdict.session_id())},
          {"attempt", verdict.attempt()},
          {"planned_index", verdict.planned_index()},
          {"posture_index", verdict.posture_index()},
          {"is_valid", verdict.is_valid()},
          {"reasons", reasons},
          {"detail", verdict.detail()},
          {"start_offset_m", verdict.start_offset_m()},
          {"rest_speed_m_per_s", verdict.rest_speed_m_per_s()},
          {"rest_force_N", verdict.rest_force_N()},
          {"excursion_m", verdict.excursion_m()},
          {"end_speed_m_per_s", verdict.end_speed_m_per_s()},
          {"saturated_samples", verdict.saturated_samples()},
          {"missing_samples", verdict.missing_samples()},
          {"muscles", muscles},
          {"co_contraction", verdict.co_contraction()}};
}

json message_json(const v1::TrialProgram& program) {
  return {{"session_id", to_hex(program.session_id())},
          {"rig_id", to_hex(program.rig_id())},
          {"attempt", program.attempt()},
          {"planned_index", program.planned_index()},
          {"kind", kind_name(program.kind())},
          {"posture", program.posture()},
          {"posture_index", program.posture_index()},
          {"posture_m", program.posture_m()},
          {"shoulder_origin_m", program.shoulder_origin_m()},
          {"shoulder_angle_rad", program.shoulder_angle_rad()},
          {"set_number", program.set_number()},
          {"instruction", program.instruction()},
          {"direction_deg", program.direction_deg()},
          {"amplitude_m", program.amplitude_m()},
          {"rise_time_s", program.rise_time_s()},
          {"hold_s", program.hold_s()},
          {"wait_s", program.wait_s()},
          {"bias_N", program.bias_N()},
          {"bias_ramp_s", program.bias_ramp_s()},
          {"bias_hold_s", program.bias_hold_s()},
          {"bias_threshold_N", program.bias_threshold_N()},
          {"recording_index", program.recording_index()},
          {"recording_event", program.recording_event()}};
}

json message_json(const v1::TrialOutcome& outcome) {
  return {{"trial_id", to_hex(outcome.trial_id())},
          {"program", message_json(outcome.program())},
          {"epoch", outcome.epoch()},
          {"end", v1::end_name(outcome.end())},
          {"detail", outcome.detail()},
          {"first_sequence", outcome.first_sequence()},
          {"onset_sequence", outcome.onset_sequence()},
          {"last_sequence", outcome.last_sequence()},
          {"sample_rate_Hz", outcome.sample_rate_Hz()}};
}

json message_json(const v1::SessionPlan& plan) {
  json postures = json::array();
  for (const v1::PlannedPosture& posture : plan.postures()) {
    postures.push_back(
        {{"name", posture.name()}, {"position_m", posture.position_m()}, {"trials", posture.trials()}});
  }
  return {{"session_id", to_hex(plan.session_id())},
          {"rig_id", to_hex(plan.rig_id())},
          {"subject", plan.subject()},
          {"protocol_name", plan.protocol_name()},
          {"protocol_toml", plan.protocol_toml()},
          {"seed", plan.seed()},
          {"planned_trials", plan.planned_trials()},
          {"postures", postures},
          {"started_at", plan.started_at()},
          {"software_version", plan.software_version()}};
}

json message_json(const v1::SessionState& state) {
  return {{"session_id", to_hex(state.session_id())},
          {"phase", v1::phase_name(state.phase())},
          {"waiting_for", state.waiting_for()},
          {"message", state.message()},
          {"posture", state.posture()},
          {"trial_id", state.trial_id() == Id{} ? json(nullptr) : json(to_hex(state.trial_id()))},
          {"attempts", state.attempts()},
          {"counted", state.counted()},
          {"rejected", state.rejected()},
          {"planned", state.planned()},
          {"remaining_s", state.remaining_s()},
          {"experiment_s", state.experiment_s()}};
}

json message_json(const v1::RigState& state) {
  return {{"rig_id", to_hex(state.rig_id())},
          {"epoch", state.epoch()},
          {"mode", v1::mode_name(state.mode())},
          {"trial_id", state.trial_id() == Id{} ? json(nullptr) : json(to_hex(state.trial_id()))},
          {"session_id", state.session_id() == Id{} ? json(nullptr) : json(to_hex(state.session_id()))},
          {"hold_number", state.hold_number()},
          {"held_because", state.held_because()},
          {"next_sequence", state.next_sequence()},
          {"received_through", state.received_through()},
          {"spool_bytes", state.spool_bytes()},
          {"fault_bits", state.fault_bits()},
          {"fault", state.fault()},
          {"overruns", state.overruns()},
          {"dropped_samples", state.dropped_samples()},
          {"is_realtime_paced", state.is_realtime_paced()},
          {"rig_clock_ns", state.rig_clock_ns()}};
}

}  // namespace tonus::contract
