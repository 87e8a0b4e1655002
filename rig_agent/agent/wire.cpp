#include "rig_agent/agent/wire.hpp"

#include <numbers>

#include "services/contract/rig.hpp"

namespace tonus::rig {
namespace {

using control::Phase;

static_assert(static_cast<int>(Phase::kIdle) == v1::PHASE_IDLE);
static_assert(static_cast<int>(Phase::kCentring) == v1::PHASE_CENTRING);
static_assert(static_cast<int>(Phase::kWaiting) == v1::PHASE_WAITING);
static_assert(static_cast<int>(Phase::kBiasRamp) == v1::PHASE_BIAS_RAMP);
static_assert(static_cast<int>(Phase::kBiasHold) == v1::PHASE_BIAS_HOLD);
static_assert(static_cast<int>(Phase::kPerturbing) == v1::PHASE_PERTURBING);
static_assert(static_cast<int>(Phase::kReturning) == v1::PHASE_RETURNING);
static_assert(static_cast<int>(Phase::kSafe) == v1::PHASE_SAFE);

std::array<double, 2> pair(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }
Eigen::Vector2d vector(const std::array<double, 2>& a) { return {a[0], a[1]}; }

}  // namespace

v1::RigDescription describe(const RigNames& names, const RigGeometry& geometry) {
  v1::RigDescription wire;
  wire.rig_id(names.id);
  wire.name(names.name);
  wire.driver(names.driver);
  contract::put_geometry(geometry, wire);
  wire.home_m(pair(names.home));
  wire.loop_rate_Hz(names.loop_rate);
  wire.sample_rate_Hz(names.sample_rate);
  wire.displacement_unit(names.displacement_unit);
  wire.force_unit(names.force_unit);
  wire.calibrated_at(names.calibrated_at);
  wire.calibrated_by(names.calibrated_by);
  wire.calibration_toml(names.calibration_toml);
  wire.moves_nothing_real(names.moves_nothing_real);
  wire.resumes_unattended(names.resumes_unattended);
  wire.watchdog_s(names.watchdog);
  wire.limits_off(names.limits_off);
  contract::put_auxiliary_channels(names.auxiliary_channels, wire);
  wire.marks_onset(names.marks_onset);
  if (names.limits) {
    v1::RigLimits limits;
    limits.workspace_centre_m(pair(names.limits->workspace_centre));
    limits.workspace_radius_m(names.limits->workspace_radius);
    limits.force_N(names.limits->force);
    wire.limits({limits});
  }
  return wire;
}

control::TrialProgram to_program(const v1::TrialProgram& wire, std::uint64_t number) {
  control::TrialProgram program;
  program.number = number;
  if (wire.kind() == v1::TRIAL_CONTRACTION) program.kind = control::TrialKind::kContraction;
  program.posture = vector(wire.posture_m());
  program.instruction = control::InstructionName(wire.instruction().data(), wire.instruction().size());
  program.shoulder = contract::shoulder_of(wire);
  program.wait = wire.wait_s();
  program.bias = vector(wire.bias_N());
  if (!program.bias.isZero()) {  // else these say nothing
    program.bias_ramp = wire.bias_ramp_s();
    program.bias_hold = wire.bias_hold_s();
    program.bias_threshold = wire.bias_threshold_N();
  }
  program.direction = wire.direction_deg() * std::numbers::pi / 180.0;
  program.amplitude = wire.amplitude_m();
  program.rise_time = wire.rise_time_s();
  program.hold = wire.hold_s();
  return program;
}

v1::RigSample to_wire(const control::SampleRecord& record) {
  v1::RigSample wire;
  wire.acquisition_ns(record.raw.acquisition_ns);
  wire.encoder_count(record.raw.encoder_count);
  wire.force_V(record.raw.force_V);
  wire.commanded_m(record.commanded);
  wire.phase(static_cast<std::uint8_t>(record.phase));
  contract::SampleFlags flags;
  flags.is_saturated = (record.flags & static_cast<std::uint16_t>(control::SampleFlag::kSaturated)) != 0;
  contract::put_flags(flags, wire);
  return wire;
}

v1::FlightCycle to_wire(const control::CycleRecord& record) {
  v1::FlightCycle wire;
  wire.cycle(record.cycle);
  wire.now_ns(record.now_ns);
  wire.encoder_count(record.raw.encoder_count);
  wire.force_V(record.raw.force_V);
  wire.position_m(record.position);
  wire.velocity_m_per_s(record.velocity);
  wire.force_N(record.force);
  wire.reference_m(record.reference);
  wire.torque_Nm(record.torque);
  wire.fault_bits(record.faults);
  wire.missed_periods(record.missed_periods);
  wire.phase(static_cast<std::uint8_t>(record.phase));
  return wire;
}

v1::TrialEnd to_wire(control::TrialOutcome outcome) {
  switch (outcome) {
    case control::TrialOutcome::kCompleted:
      return v1::TRIAL_COMPLETED;
    case control::TrialOutcome::kAborted:
      return v1::TRIAL_ABORTED;
    case control::TrialOutcome::kFault:
      return v1::TRIAL_FAULTED;
    case control::TrialOutcome::kNotCentred:
      return v1::TRIAL_NOT_CENTRED;
    case control::TrialOutcome::kBiasNotReached:
      return v1::TRIAL_BIAS_NOT_REACHED;
    case control::TrialOutcome::kNoRecording:
      return v1::TRIAL_REFUSED;
  }
  return v1::TRIAL_FAULTED;
}

}  // namespace tonus::rig
