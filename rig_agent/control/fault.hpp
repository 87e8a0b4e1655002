#pragma once

#include <cstdint>

namespace tonus::control {

/// Reasons for the safe state, one bit each. A fault latches: it stays until an operator clears it, and it
/// can be cleared only when its cause is gone.
enum class Fault : std::uint32_t {
  kWorkspace = 1U << 0,            ///< The handle left the allowed circle.
  kSpeed = 1U << 1,                ///< The handle was faster than allowed.
  kForce = 1U << 2,                ///< The force at the handle was larger than allowed.
  kTorque = 1U << 3,               ///< The control law asked for more torque than allowed.
  kEncoderJump = 1U << 4,          ///< A joint moved further in one cycle than it can.
  kSensorSaturated = 1U << 5,      ///< A force channel is at its end stop.
  kNotFinite = 1U << 6,            ///< A measured or computed number is not finite.
  kCommandTimeout = 1U << 7,       ///< Nobody was heard from during a trial.
  kOverrun = 1U << 8,              ///< The loop missed more periods at once than allowed.
  kEmergencyStop = 1U << 9,        ///< Topic, signal or the device's own input.
  kDriver = 1U << 10,              ///< The driver failed, or a sensor is disconnected.
  kHeld = 1U << 11,                ///< Held from outside the loop: a restart, a lost partner, another agent.
  kWatchdog = 1U << 12,            ///< The watchdog dropped the torque, or is gone.
  kOverrunRate = 1U << 13,         ///< The loop missed a larger share of its periods than allowed.
  kEncoderStill = 1U << 14,        ///< A joint's load changed and its encoder did not move.
  kEncoderReversed = 1U << 15,     ///< A joint's counts go against what torque and force do to it.
  kForceStill = 1U << 16,          ///< The handle moved and a force channel did not change.
  kForceAgainstMotion = 1U << 17,  ///< Force and motion contradict each other: a reversed channel.
  kEnergy = 1U << 18,              ///< The hand was given more energy in a trial than allowed.
  kForceJump = 1U << 19,           ///< A force channel changed further in one cycle than a force can.
};

/// A set of faults.
using FaultBits = std::uint32_t;

constexpr FaultBits bit(Fault fault) { return static_cast<FaultBits>(fault); }

/// One short word per single fault, for logs and outcomes: "workspace", "speed", ... "driver".
[[nodiscard]] const char* fault_name(Fault fault) noexcept;

/// Faults after which the measured motion, or its time, cannot be trusted: no damping torque is computed from
/// it.
inline constexpr FaultBits kMotionFaults = bit(Fault::kEncoderJump) | bit(Fault::kNotFinite) |
                                           bit(Fault::kDriver) | bit(Fault::kEncoderStill) |
                                           bit(Fault::kEncoderReversed) | bit(Fault::kForceAgainstMotion) |
                                           bit(Fault::kWatchdog) | bit(Fault::kOverrunRate);

/// All faults in the order of their bits.
inline constexpr Fault kAllFaults[] = {
    Fault::kWorkspace,       Fault::kSpeed,          Fault::kForce,
    Fault::kTorque,          Fault::kEncoderJump,    Fault::kSensorSaturated,
    Fault::kNotFinite,       Fault::kCommandTimeout, Fault::kOverrun,
    Fault::kEmergencyStop,   Fault::kDriver,         Fault::kHeld,
    Fault::kWatchdog,        Fault::kOverrunRate,    Fault::kEncoderStill,
    Fault::kEncoderReversed, Fault::kForceStill,     Fault::kForceAgainstMotion,
    Fault::kEnergy,          Fault::kForceJump};

}  // namespace tonus::control
