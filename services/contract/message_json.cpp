#include "services/contract/message_json.hpp"

#include <nlohmann/json.hpp>

#include "services/contract/estimate_json.hpp"
#include "services/contract/names.hpp"
#include "services/contract/subject_json.hpp"
#include "services/core/id.hpp"

namespace tonus::contract {

using nlohmann::json;

namespace {

json id_or_null(const Id& id) { return id == Id{} ? json(nullptr) : json(to_hex(id)); }

const char* trial_kind_name(v1::TrialKind kind) {
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

const char* rig_kind_name(v1::RigKind kind) {
  switch (kind) {
    case v1::RIG_TWO_LINK:
      return "two-link";
    case v1::RIG_CARTESIAN:
      return "cartesian";
    case v1::RIG_ONE_AXIS:
      return "one-axis";
  }
  return "unknown";
}

json condition_json(const v1::ConditionProgress& progress) {
  return {{"posture", progress.posture()},         {"posture_index", progress.posture_index()},
          {"set_number", progress.set_number()},   {"instruction", progress.instruction()},
          {"counted", progress.counted()},         {"planned", progress.planned()},
          {"precision", progress.precision()},     {"precision_goal", progress.precision_goal()},
          {"is_finished", progress.is_finished()}, {"finished_because", progress.finished_because()}};
}

json channel_json(const v1::AuxiliaryChannel& channel) {
  return {{"name", channel.name()},
          {"type", channel.type()},
          {"unit", channel.unit()},
          {"unit_per_value", channel.unit_per_value()},
          {"values_per_sample", channel.values_per_sample()}};
}

json muscle_json(const v1::MuscleActivity& muscle) {
  return {{"channel", muscle.channel()},
          {"is_normalised", muscle.is_normalised()},
          {"before_onset", muscle.before_onset()},
          {"short_latency", muscle.short_latency()},
          {"long_latency", muscle.long_latency()}};
}

template <typename List, typename ToJson>
json list_json(const List& list, const ToJson& to_json) {
  json all = json::array();
  for (const auto& one : list) all.push_back(to_json(one));
  return all;
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
          {"muscles", list_json(verdict.muscles(), muscle_json)},
          {"co_contraction", verdict.co_contraction()}};
}

json message_json(const v1::TrialReview& review) {
  return {{"trial_id", to_hex(review.trial_id())},
          {"session_id", to_hex(review.session_id())},
          {"attempt", review.attempt()},
          {"planned_index", review.planned_index()},
          {"posture_index", review.posture_index()},
          {"is_rejected", review.is_rejected()},
          {"reason", review.reason()},
          {"reviewed_by", review.reviewed_by()},
          {"reviewed_ns", review.reviewed_ns()}};
}

json message_json(const v1::TrialProgram& program) {
  return {{"session_id", to_hex(program.session_id())},
          {"rig_id", to_hex(program.rig_id())},
          {"attempt", program.attempt()},
          {"planned_index", program.planned_index()},
          {"kind", trial_kind_name(program.kind())},
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
          {"sample_rate_Hz", outcome.sample_rate_Hz()},
          {"is_onset_marked", outcome.is_onset_marked()},
          {"mark_sequence", outcome.is_onset_marked() ? json(outcome.mark_sequence()) : json(nullptr)}};
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
          {"subject_facts", message_json(plan.subject_facts())},
          {"operator_name", plan.operator_name()},
          {"study", plan.study()},
          {"is_pilot", plan.is_pilot()},
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
          {"trial_id", id_or_null(state.trial_id())},
          {"attempts", state.attempts()},
          {"counted", state.counted()},
          {"rejected", state.rejected()},
          {"planned", state.planned()},
          {"remaining_s", state.remaining_s()},
          {"experiment_s", state.experiment_s()},
          {"conditions", list_json(state.conditions(), condition_json)}};
}

json message_json(const v1::SessionNote& note) {
  return {{"note_id", to_hex(note.note_id())},
          {"session_id", to_hex(note.session_id())},
          {"trial_id", id_or_null(note.trial_id())},
          {"kind", note.kind()},
          {"text", note.text()},
          {"written_by", note.written_by()},
          {"written_ns", note.written_ns()},
          {"has_rig_clock", note.has_rig_clock()},
          {"rig_clock_ns", note.has_rig_clock() ? json(note.rig_clock_ns()) : json(nullptr)},
          {"epoch", note.epoch()}};
}

json message_json(const v1::RigState& state) {
  return {{"rig_id", to_hex(state.rig_id())},
          {"epoch", state.epoch()},
          {"mode", v1::mode_name(state.mode())},
          {"trial_id", id_or_null(state.trial_id())},
          {"session_id", id_or_null(state.session_id())},
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

json message_json(const v1::RigDescription& d) {
  const auto limits_json = [](const v1::RigLimits& limits) {
    return json{{"workspace_centre_m", limits.workspace_centre_m()},
                {"workspace_radius_m", limits.workspace_radius_m()},
                {"force_N", limits.force_N()}};
  };
  return {{"rig_id", to_hex(d.rig_id())},
          {"name", d.name()},
          {"driver", d.driver()},
          {"kind", rig_kind_name(d.kind())},
          {"link_lengths_m", d.link_lengths_m()},
          {"encoder_counts_per_unit", d.encoder_counts_per_unit()},
          {"encoder_zero_count", d.encoder_zero_count()},
          {"encoder_sign", d.encoder_sign()},
          {"force_calibration_N_per_V", d.force_calibration_N_per_V()},
          {"force_offset_V", d.force_offset_V()},
          {"force_sensor_angle_rad", d.force_sensor_angle_rad()},
          {"force_saturation_V", d.force_saturation_V()},
          {"handle_mass_kg", d.handle_mass_kg()},
          {"home_m", d.home_m()},
          {"loop_rate_Hz", d.loop_rate_Hz()},
          {"sample_rate_Hz", d.sample_rate_Hz()},
          {"displacement_unit", d.displacement_unit()},
          {"force_unit", d.force_unit()},
          {"calibrated_at", d.calibrated_at()},
          {"calibrated_by", d.calibrated_by()},
          {"calibration_toml", d.calibration_toml()},
          {"moves_nothing_real", d.moves_nothing_real()},
          {"resumes_unattended", d.resumes_unattended()},
          {"watchdog_s", d.watchdog_s()},
          {"limits_off", d.limits_off()},
          {"limits", list_json(d.limits(), limits_json)},
          {"auxiliary_channels", list_json(d.auxiliary_channels(), channel_json)},
          {"marks_onset", d.marks_onset()}};
}

}  // namespace tonus::contract
