#pragma once

#include <array>
#include <cstdint>

#include "services/mechanics/rig_geometry.hpp"

namespace tonus::control {

/// Where the loop is in a trial.
enum class Phase : std::uint8_t {
  kIdle,        ///< No trial. The handle floats: no force but damping.
  kCentring,    ///< The handle is led to the posture and settles there.
  kWaiting,     ///< Zero force on the hand for the drawn waiting time.
  kBiasRamp,    ///< The bias force rises.
  kBiasHold,    ///< The bias force is to stay within its threshold.
  kPerturbing,  ///< From the onset to the end of the hold.
  kReturning,   ///< Back to the posture, bias going to zero.
  kSafe,        ///< A fault is latched: damping until at rest, then no torque.
};

[[nodiscard]] const char* phase_name(Phase phase) noexcept;

/// Remarks on one sample, one bit each.
enum class SampleFlag : std::uint16_t {
  kOnset = 1U << 0,      ///< First sample of the perturbation: see TrialResult::onset_sequence.
  kSaturated = 1U << 1,  ///< A force channel is at its end stop.
  kFault = 1U << 2,      ///< A fault is latched.
  kOverrun = 1U << 3,    ///< The loop missed a period since the sample before.
  kAtRest = 1U << 4,     ///< The handle was still (speed below the limit of the trial's centring).
};

/// One acquired row, at a whole fraction of the loop rate. Plain data.
struct SampleRecord {
  std::uint64_t sequence = 0;  ///< From 0 at the start of the loop, without gaps.
  std::uint64_t trial = 0;     ///< TrialProgram::number, 0 outside trials.
  RawSample raw;
  std::array<double, 2> commanded{};  ///< m in S, commanded displacement from where the hand was at onset.
  std::array<double, 2> bias{};       ///< N in S, bias force commanded on the arm.
  Phase phase = Phase::kIdle;
  std::uint16_t flags = 0;  ///< Set of SampleFlag.
};

}  // namespace tonus::control
