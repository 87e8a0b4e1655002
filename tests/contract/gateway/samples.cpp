#include "tests/contract/gateway/samples.hpp"

#include <stdexcept>

#include "idl/topics.hpp"
#include "services/core/id.hpp"

namespace tonus::testing {
namespace {

using nlohmann::json;

Id key(std::uint8_t first) {
  Id id{};
  for (std::size_t i = 0; i < id.size(); ++i) id[i] = static_cast<std::uint8_t>(first + i);
  return id;
}

template <typename T>
SampleMessage message(const bus::Topic<T>& topic, const T& value, json expected) {
  auto payload = bus::encode(value);
  if (!payload) throw std::runtime_error(payload.error().message);
  return {topic.spec, std::move(*payload), std::move(expected)};
}

v1::TrialProgram program() {
  v1::TrialProgram p;
  p.session_id(key(1));
  p.rig_id(key(2));
  p.attempt(7);
  p.planned_index(6);
  p.kind(v1::TRIAL_RECORDING);
  p.posture("right");
  p.posture_index(3);
  p.posture_m({0.295, 0.38});
  p.shoulder_origin_m({0.01, -0.02});
  p.shoulder_angle_rad(0.125);
  p.set_number(-2);
  p.instruction("stay soft");
  p.direction_deg(45);
  p.amplitude_m(0.005);
  p.rise_time_s(0.2);
  p.hold_s(1.75);
  p.wait_s(3.5);
  p.bias_N({1.5, -2.5});
  p.bias_ramp_s(1);
  p.bias_hold_s(2);
  p.bias_threshold_N(0.5);
  p.recording_index(-1);
  p.recording_event(12345);
  return p;
}

SampleMessage rig_description() {
  v1::RigDescription d;
  d.rig_id(key(3));
  d.name("rig");
  d.driver("simulated");
  d.kind(v1::RIG_ONE_AXIS);
  d.link_lengths_m({0.3, 0.35});
  d.encoder_sign({1, -1});
  d.force_calibration_N_per_V({1, 2, 3, 4});
  d.sample_rate_Hz(1000);
  d.displacement_unit("rad");
  d.force_unit("N m");
  d.calibrated_at("2026-03-01");
  d.calibrated_by("somebody");
  d.calibration_toml("step = 1\n");
  return message(topics::kRigDescription, d,
                 {{"kind", "2"},
                  {"encoder_sign.1", "-1"},
                  {"force_calibration_N_per_V.3", "4"},
                  {"force_unit", "N m"},
                  {"calibration_toml", "step = 1\n"}});
}

SampleMessage rig_state() {
  v1::RigState s;
  s.rig_id(key(4));
  s.epoch(1234567890123456789ULL);
  s.mode(v1::RIG_HELD);
  s.hold_number(7);
  s.held_because("stop");
  s.next_sequence(99);
  s.fault_bits(0x80000001U);
  s.fault("limit");
  s.is_realtime_paced(true);
  s.rig_clock_ns(-5);
  return message(topics::kRigState, s,
                 {{"epoch", "1234567890123456789"},
                  {"mode", "4"},
                  {"hold_number", "7"},
                  {"held_because", "stop"},
                  {"fault_bits", "2147483649"},
                  {"is_realtime_paced", "true"},
                  {"rig_clock_ns", "-5"}});
}

SampleMessage rig_samples() {
  v1::RigSample sample;
  sample.acquisition_ns(1000000);
  sample.encoder_count({-7, 8});
  sample.force_V({0.25, -0.5});
  sample.phase(v1::PHASE_SAFE);
  sample.flags(3);
  v1::SampleBlock b;
  b.rig_id(key(5));
  b.epoch(5);
  b.first_sequence(40);
  b.is_resent(true);
  b.send_ns(77);
  b.samples({sample, sample, sample});
  return message(topics::kRigSamples, b,
                 {{"first_sequence", "40"},
                  {"is_resent", "true"},
                  {"samples.length", "3"},
                  {"samples.2.encoder_count.0", "-7"},
                  {"samples.2.phase", "7"},
                  {"samples.2.flags", "3"}});
}

SampleMessage rig_auxiliary() {
  v1::AuxiliaryBlock b;
  b.rig_id(key(37));
  b.epoch(5);
  b.first_sequence(40);
  b.sample_count(2);
  b.is_resent(true);
  b.values({0.25F, -1.5F, 3.0F, 4.0F});
  return message(topics::kRigAuxiliary, b,
                 {{"first_sequence", "40"},
                  {"sample_count", "2"},
                  {"is_resent", "true"},
                  {"values.length", "4"},
                  {"values.1", "-1.5"}});
}

SampleMessage rig_timing() {
  v1::RigTiming t;
  t.rig_id(key(6));
  t.scheduling("SCHED_FIFO refused");
  t.period_s(0.001);
  t.worst_lateness_ns(-3);
  auto& counts = t.lateness_count();
  counts.front() = 11;
  counts.back() = 22;
  return message(topics::kRigTiming, t,
                 {{"scheduling", "SCHED_FIFO refused"},
                  {"period_s", "0.001"},
                  {"lateness_count.0", "11"},
                  {"lateness_count.17", "22"}});
}

SampleMessage flight_record() {
  v1::FlightCycle cycle;
  cycle.cycle(42);
  cycle.torque_Nm({0.5, 0.75});
  cycle.missed_periods(9);
  cycle.phase(v1::PHASE_WAITING);
  v1::FlightRecord r;
  r.part_id(key(7));
  r.fault("speed");
  r.parts(8);
  r.cycles({cycle, cycle});
  return message(topics::kRigFlightRecord, r,
                 {{"fault", "speed"},
                  {"cycles.length", "2"},
                  {"cycles.1.cycle", "42"},
                  {"cycles.1.torque_Nm.1", "0.75"},
                  {"cycles.1.phase", "2"}});
}

SampleMessage rig_command() {
  v1::RigCommand c;
  c.rig_id(key(8));
  c.request_id(key(9));
  c.request(v1::RIG_ABORT_TRIAL);
  c.trial_id(key(10));
  c.requested_by("contract test");
  return message(topics::kRigCommand, c,
                 {{"request", "2"}, {"trial_id.15", "25"}, {"requested_by", "contract test"}});
}

SampleMessage rig_reply() {
  v1::RigReply r;
  r.rig_id(key(11));
  r.request_id(key(12));
  r.is_done(true);
  r.message("arr\u00eat\u00e9");
  r.rig_clock_ns(9007199254740993LL);  // no double holds it
  return message(
      topics::kRigReply, r,
      {{"is_done", "true"}, {"message", "arr\u00eat\u00e9"}, {"rig_clock_ns", "9007199254740993"}});
}

SampleMessage rig_stop() {
  v1::RigStop s;
  s.rig_id(key(31));
  s.stop_id(key(32));
  s.number(3);
  s.requested_by("contract test");
  return message(topics::kRigStop, s, {{"stop_id.0", "32"}, {"number", "3"}});
}

SampleMessage rig_stopped() {
  v1::RigStop s;
  s.rig_id(key(35));
  s.stop_id(key(36));
  return message(topics::kRigStopped, s, {{"stop_id.0", "36"}});
}

SampleMessage rig_lease() {
  v1::RigLease l;
  l.rig_id(key(33));
  l.session_id(key(34));
  l.epoch(35);
  l.number(36);
  return message(topics::kRigLease, l, {{"epoch", "35"}, {"number", "36"}});
}

SampleMessage trial_command() {
  v1::TrialCommand c;
  c.trial_id(key(13));
  c.program(program());
  return message(topics::kTrialCommand, c,
                 {{"program.posture", "right"},
                  {"program.set_number", "-2"},
                  {"program.instruction", "stay soft"},
                  {"program.recording_index", "-1"},
                  {"program.recording_event", "12345"}});
}

SampleMessage trial_outcome() {
  v1::TrialOutcome o;
  o.trial_id(key(14));
  o.program(program());
  o.epoch(6);
  o.end(v1::TRIAL_REFUSED);
  o.detail("no");
  o.sample_rate_Hz(200.5);
  return message(topics::kTrialOutcome, o, {{"end", "5"}, {"detail", "no"}, {"sample_rate_Hz", "200.5"}});
}

SampleMessage trial_verdict() {
  v1::TrialVerdict v;
  v.trial_id(key(15));
  v.is_valid(true);
  v.reasons({v1::REASON_GAP, v1::REASON_UNKNOWN_RIG});
  v.detail("two reasons");
  v.rest_force_N(0.125);
  v.missing_samples(4294967295U);
  return message(topics::kTrialVerdict, v,
                 {{"is_valid", "true"},
                  {"reasons.length", "2"},
                  {"reasons.0", "6"},
                  {"reasons.1", "9"},
                  {"rest_force_N", "0.125"},
                  {"missing_samples", "4294967295"}});
}

SampleMessage trial_review() {
  v1::TrialReview r;
  r.trial_id(key(38));
  r.attempt(7);
  r.posture_index(2);
  r.is_rejected(true);
  r.reason("the subject spoke");
  r.reviewed_by("contract test");
  r.reviewed_ns(18446744073709551615ULL);
  return message(topics::kTrialReview, r,
                 {{"attempt", "7"},
                  {"posture_index", "2"},
                  {"is_rejected", "true"},
                  {"reason", "the subject spoke"},
                  {"reviewed_ns", "18446744073709551615"}});
}

v1::Estimate estimate() {
  v1::Estimate e;
  e.estimate_id(key(16));
  e.posture("left");
  e.posture_m({-0.295, 0.38});
  e.method("optimal");
  e.model("linear");
  e.axes(2);
  e.displacement_unit("m");
  e.force_unit("N");
  e.status(v1::ESTIMATE_SUSPECT);
  e.reasons({"one", "", "three"});
  e.samples(123456789012ULL);
  v1::MatrixEstimate matrix;
  matrix.value({300.5, -20, -30, 150});
  matrix.has_ellipse(true);
  matrix.curl(-0.0625);
  e.stiffness_N_per_m(matrix);
  e.sigma_N({0.25, 0.5});
  e.settled_s(-1);
  v1::FitCheck check;
  check.test(v1::FIT_LAG);
  check.value(0.0005);
  check.limit(0.001);
  check.passed(true);
  e.checks({check});
  v1::TrialRange range;
  range.attempt(3);
  range.last_sequence(1000);
  e.trials({range});
  return e;
}

json estimate_facts() {
  return {{"posture", "left"},
          {"status", "2"},
          {"reasons.length", "3"},
          {"reasons.2", "three"},
          {"stiffness_N_per_m.value.0", "300.5"},
          {"stiffness_N_per_m.has_ellipse", "true"},
          {"stiffness_N_per_m.curl", "-0.0625"},
          {"settled_s", "-1"},
          {"checks.0.test", "6"},
          {"checks.0.passed", "true"},
          {"trials.0.last_sequence", "1000"}};
}

SampleMessage session_plan() {
  v1::PlannedPosture posture;
  posture.name("distal");
  posture.position_m({0, 0.52});
  posture.trials(16);
  v1::SessionPlan p;
  p.session_id(key(17));
  p.subject("sub-01");
  p.protocol_toml("a = 'b'");
  p.seed(18446744073709551615ULL);
  p.postures({posture, posture});
  p.software_version("0.1.0");
  return message(topics::kSessionPlan, p,
                 {{"seed", "18446744073709551615"},
                  {"postures.1.name", "distal"},
                  {"postures.1.position_m.1", "0.52"},
                  {"software_version", "0.1.0"}});
}

SampleMessage session_state() {
  v1::SessionState s;
  s.session_id(key(18));
  s.phase(v1::SESSION_FAILED);
  s.waiting_for("archive");
  s.counted(12);
  s.experiment_s(3600.25);
  return message(
      topics::kSessionState, s,
      {{"phase", "9"}, {"waiting_for", "archive"}, {"counted", "12"}, {"experiment_s", "3600.25"}});
}

SampleMessage session_command() {
  v1::SessionCommand c;
  c.session_id(key(19));
  c.request_id(key(20));
  c.request(v1::SESSION_ABORT);
  c.protocol_toml("x = 1");
  c.subject("sub-03");
  c.seed(3);
  c.requested_by("contract test");
  return message(topics::kSessionCommand, c,
                 {{"request", "3"}, {"subject", "sub-03"}, {"seed", "3"}, {"requested_by", "contract test"}});
}

SampleMessage session_reply() {
  v1::SessionReply r;
  r.session_id(key(21));
  r.request_id(key(22));
  r.is_done(true);
  r.message("80 trials planned");
  return message(topics::kSessionReply, r, {{"is_done", "true"}, {"message", "80 trials planned"}});
}

SampleMessage session_note() {
  v1::SessionNote n;
  n.note_id(key(39));
  n.kind("marker");
  n.text("cuff on");
  n.written_by("contract test");
  n.has_rig_clock(true);
  n.rig_clock_ns(-5);
  n.epoch(6);
  return message(topics::kSessionNote, n,
                 {{"kind", "marker"},
                  {"text", "cuff on"},
                  {"has_rig_clock", "true"},
                  {"rig_clock_ns", "-5"},
                  {"epoch", "6"}});
}

SampleMessage session_cue() {
  v1::SessionCue c;
  c.session_id(key(23));
  c.target_m({0.1, 0.2});
  c.target_diameter_m(0.01);
  c.instruction("hold");
  c.shows_cursor(true);
  return message(topics::kSessionCue, c,
                 {{"target_m.1", "0.2"},
                  {"target_diameter_m", "0.01"},
                  {"instruction", "hold"},
                  {"shows_cursor", "true"}});
}

SampleMessage archive_receipt() {
  v1::ArchiveReceipt r;
  r.subject_id(key(24));
  r.kind(v1::RECEIPT_SESSION);
  r.missing_samples(17);
  return message(topics::kArchiveReceipt, r, {{"kind", "2"}, {"missing_samples", "17"}});
}

SampleMessage archive_resend() {
  v1::ArchiveResend r;
  r.rig_id(key(25));
  r.first_sequence(1);
  r.last_sequence(2);
  r.requested_by("archive");
  return message(topics::kArchiveResend, r, {{"last_sequence", "2"}, {"requested_by", "archive"}});
}

SampleMessage service_health() {
  v1::ServiceHealth h;
  h.instance_id(key(26));
  h.role(v1::ROLE_OPERATOR);
  h.name("rig");
  h.is_ready(true);
  h.state("works");
  h.host("lab-pc");
  h.warnings({"no watchdog"});
  h.lag_s(0.001);
  h.dropped(4);
  h.is_leaving(true);
  return message(topics::kServiceHealth, h,
                 {{"role", "5"},
                  {"state", "works"},
                  {"host", "lab-pc"},
                  {"warnings.0", "no watchdog"},
                  {"lag_s", "0.001"},
                  {"dropped", "4"},
                  {"is_leaving", "true"}});
}

SampleMessage service_configuration() {
  v1::ServiceConfiguration c;
  c.instance_id(key(27));
  c.role(v1::ROLE_ARCHIVE);
  c.build("gcc");
  c.configuration_toml("store = 'x'");
  c.started_ns(8);
  return message(topics::kServiceConfiguration, c,
                 {{"role", "3"}, {"configuration_toml", "store = 'x'"}, {"started_ns", "8"}});
}

SampleMessage clock_probe() {
  v1::ClockProbe p;
  p.asker_id(key(28));
  p.number(5);
  p.asked_ns(-6);
  return message(topics::kClockProbe, p, {{"number", "5"}, {"asked_ns", "-6"}});
}

SampleMessage clock_echo() {
  v1::ClockEcho e;
  e.asker_id(key(29));
  e.number(5);
  e.answered_ns(9);
  return message(topics::kClockEcho, e, {{"number", "5"}, {"answered_ns", "9"}});
}

SampleMessage clock_offset() {
  v1::ClockOffset o;
  o.pair_id(key(30));
  o.offset_ns(-1);
  o.measured_ns(10);
  return message(topics::kClockOffset, o, {{"offset_ns", "-1"}, {"measured_ns", "10"}});
}

}  // namespace

std::vector<SampleMessage> sample_messages() {
  return {rig_description(),
          rig_state(),
          rig_samples(),
          rig_timing(),
          flight_record(),
          rig_command(),
          rig_reply(),
          trial_command(),
          trial_outcome(),
          trial_verdict(),
          message(topics::kEstimateLive, estimate(), estimate_facts()),
          message(topics::kEstimateCondition, estimate(), estimate_facts()),
          session_plan(),
          session_state(),
          session_command(),
          session_reply(),
          session_cue(),
          archive_receipt(),
          archive_resend(),
          service_health(),
          service_configuration(),
          clock_probe(),
          clock_echo(),
          clock_offset(),
          rig_stop(),
          rig_stopped(),
          rig_lease(),
          rig_auxiliary(),
          trial_review(),
          session_note()};
}

}  // namespace tonus::testing
