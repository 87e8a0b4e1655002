#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "rig_agent/control/fault.hpp"
#include "rig_agent/control/instruction_name.hpp"
#include "rig_agent/control/sample_record.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::control {

enum class TrialKind : std::uint8_t {
  kPerturbation,
  kContraction,  ///< The handle is held still while the subject contracts.
};

/// One trial, complete: the loop runs it alone. SI, in the shoulder frame S; a force acts on the arm.
///
///     centring -> waiting -> [bias ramp -> bias hold] -> perturbing -> returning -> done
///
/// The bias phases are left out when `bias` is zero. With a driver that does not actuate, the trial is one
/// segment of the recording: waiting up to its onset, perturbing up to its last row.
///
/// In a contraction nothing perturbs: from the onset on the handle is held where it is for `hold`, in the
/// phase of the perturbation with a commanded displacement of zero. `bias`, `direction`, `amplitude` and
/// `rise_time` say nothing.
struct TrialProgram {
  std::uint64_t number = 0;  ///< Echoed in samples and result; not 0.
  TrialKind kind = TrialKind::kPerturbation;

  Eigen::Vector2d posture = Eigen::Vector2d::Zero();  ///< p_SE, m.
  ShoulderPose shoulder;                              ///< Where the subject sits for this posture.
  std::uint32_t segment = 0;                          ///< Of a recording; see drivers::TrialNotice.
  InstructionName instruction;                        ///< What the subject is told.

  double centring_time = 1.0;         ///< s, minimum-jerk way to the posture.
  double centring_timeout = 10.0;     ///< s, then the outcome is kNotCentred.
  double centring_tolerance = 0.005;  ///< m, half of the target circle's diameter.
  double rest_speed = 0.005;          ///< m/s, below which the hand is at rest.
  double rest_time = 0.25;            ///< s at rest and on target before waiting starts.

  double wait =
      4.0;  ///< s from the end of centring to the onset (or the bias ramp), as drawn for this trial.

  Eigen::Vector2d bias = Eigen::Vector2d::Zero();  ///< N.
  double bias_ramp = 2.5;                          ///< s, smooth rise from zero.
  double bias_hold = 1.0;       ///< s within the threshold without a break, then the onset.
  double bias_threshold = 0.1;  ///< N, largest distance of the measured force (low-passed) from the bias.
  double bias_timeout = 8.0;    ///< s after the ramp, then the outcome is kBiasNotReached.

  double direction = 0.0;    ///< rad in S, counter-clockwise from +x.
  double amplitude = 0.005;  ///< m, commanded displacement.
  double rise_time = 0.2;    ///< s from the onset to the first peak; sets the servo's natural frequency.
  double hold = 1.75;        ///< s from the onset to the end of the perturbation.

  double return_time = 0.5;  ///< s, minimum-jerk way back.
};

/// How a trial ended. It says what happened, not whether the data are good.
enum class TrialOutcome : std::uint8_t {
  kCompleted,       ///< Every phase was run.
  kAborted,         ///< By command.
  kFault,           ///< A safety limit; see TrialResult::faults.
  kNotCentred,      ///< The hand did not come to rest on the target in time.
  kBiasNotReached,  ///< The bias force was not held within its threshold in time.
  kNoRecording,     ///< The recording has no such segment.
};

[[nodiscard]] const char* outcome_name(TrialOutcome outcome) noexcept;

/// What happened in a trial. Sequence numbers are SampleRecord::sequence, times are acquisition stamps, ns.
struct TrialResult {
  std::uint64_t number = 0;
  TrialOutcome outcome = TrialOutcome::kFault;
  Phase ended_in = Phase::kIdle;  ///< Phase that was running when it ended; kReturning for a completed one.
  FaultBits faults = 0;
  bool has_onset = false;
  std::uint64_t samples = 0;         ///< That bear the trial's number; 0 only without a recording.
  std::uint64_t first_sequence = 0;  ///< First sample that bears the trial's number.
  /// The sample taken at the instant from which the displacement is commanded: its raw values are the last
  /// before the hand moves, its `commanded` is the step.
  std::uint64_t onset_sequence = 0;
  std::uint64_t last_sequence = 0;  ///< Last sample that bears the trial's number; inclusive.
  bool is_onset_marked = false;     ///< By the driver's digital output.
  std::uint64_t mark_sequence = 0;  ///< Sample in whose cycle the output went high.
  std::int64_t first_ns = 0;
  std::int64_t onset_ns = 0;
  std::int64_t last_ns = 0;
};

}  // namespace tonus::control
