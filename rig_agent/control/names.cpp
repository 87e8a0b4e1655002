#include "rig_agent/control/fault.hpp"
#include "rig_agent/control/sample_record.hpp"
#include "rig_agent/control/trial_program.hpp"

namespace tonus::control {

const char* fault_name(Fault fault) noexcept {
  switch (fault) {
    case Fault::kWorkspace:
      return "workspace";
    case Fault::kSpeed:
      return "speed";
    case Fault::kForce:
      return "force";
    case Fault::kTorque:
      return "torque";
    case Fault::kEncoderJump:
      return "encoder_jump";
    case Fault::kSensorSaturated:
      return "sensor_saturated";
    case Fault::kNotFinite:
      return "not_finite";
    case Fault::kCommandTimeout:
      return "command_timeout";
    case Fault::kOverrun:
      return "overrun";
    case Fault::kEmergencyStop:
      return "emergency_stop";
    case Fault::kDriver:
      return "driver";
    case Fault::kHeld:
      return "held";
    case Fault::kWatchdog:
      return "watchdog";
    case Fault::kOverrunRate:
      return "overrun_rate";
    case Fault::kEncoderStill:
      return "encoder_still";
    case Fault::kEncoderReversed:
      return "encoder_reversed";
    case Fault::kForceStill:
      return "force_still";
    case Fault::kForceAgainstMotion:
      return "force_against_motion";
    case Fault::kEnergy:
      return "energy";
    case Fault::kForceJump:
      return "force_jump";
  }
  return "unknown";
}

const char* phase_name(Phase phase) noexcept {
  switch (phase) {
    case Phase::kIdle:
      return "idle";
    case Phase::kCentring:
      return "centring";
    case Phase::kWaiting:
      return "waiting";
    case Phase::kBiasRamp:
      return "bias_ramp";
    case Phase::kBiasHold:
      return "bias_hold";
    case Phase::kPerturbing:
      return "perturbing";
    case Phase::kReturning:
      return "returning";
    case Phase::kSafe:
      return "safe";
  }
  return "unknown";
}

const char* outcome_name(TrialOutcome outcome) noexcept {
  switch (outcome) {
    case TrialOutcome::kCompleted:
      return "completed";
    case TrialOutcome::kAborted:
      return "aborted";
    case TrialOutcome::kFault:
      return "fault";
    case TrialOutcome::kNotCentred:
      return "not_centred";
    case TrialOutcome::kBiasNotReached:
      return "bias_not_reached";
    case TrialOutcome::kNoRecording:
      return "no_recording";
  }
  return "unknown";
}

}  // namespace tonus::control
