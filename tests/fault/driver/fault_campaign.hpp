#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rig_agent/control/fault.hpp"
#include "rig_agent/control/sample_record.hpp"
#include "tests/fault/driver/faulty_driver.hpp"

namespace tonus::testing {

/// One faulty device in one trial, drawn from a seed: which fault, axis, size and phase, where the arm is and
/// how it is perturbed; and what became of the hand, as the plant knows it.
struct FaultCase {
  DeviceFault fault = DeviceFault::kReadingFrozen;
  control::Phase phase = control::Phase::kIdle;  ///< In which it began.
  control::FaultBits found = 0;                  ///< What the loop named; 0: nothing.
  int cycles_to_detection = -1;                  ///< -1: not detected.
  double way_beyond = 0.0;                       ///< m beyond the workspace; negative: within.
  double force_share = 0.0;                      ///< Largest force on the hand over the limit.
  int cycles_under_torque = 0;                   ///< From detection to the last torque that drove the hand.
  bool was_harmless = false;                     ///< Not found, and the trial went on within all limits.
};

/// How hard it is made.
struct Hardness {
  int trials_after = 0;  ///< That are run with a fault which its own trial did not show.
  bool is_model_wrong =
      false;  ///< The law's model is off by up to 15 % in inertia, a factor of 2 in friction.
  /// Four healthy trials each: motors of 0.2 to 1 of their torque, friction of 0.3 to 3 times the stated one,
  /// an arm of 0.05 to 3.9 times the stiffness and 0.5 to 2 times the mass, the widest limit on the
  /// unexplained torque.
  bool is_rig_other = false;
};

[[nodiscard]] FaultCase run_fault_case(std::uint64_t seed, const Hardness& hardness = {});

/// Trials without any fault, drawn likewise; what the loop found all the same: 0 is right.
[[nodiscard]] control::FaultBits run_healthy_case(std::uint64_t seed, const Hardness& hardness = {});

/// What the safe state's torque did to a handle that was stopped by hand while it moved, as the plant knows
/// it.
struct StopCase {
  double energy_at_stop = 0.0;      ///< J, of the handle's motion.
  double energy_put_in = 0.0;       ///< J, the most that the torque had given since the stop at any instant.
  double energy_taken = 0.0;        ///< J, by the torque in the end.
  double way_beyond = 0.0;          ///< m beyond the workspace; negative: within.
  double speed_when_dropped = 0.0;  ///< m/s of the handle in the first cycle without torque; 0: never.
  int cycles_under_torque = 0;
};

/// An emergency stop at a random instant of a trial, up to 0.4 s after `fault` began; none: a sound rig.
[[nodiscard]] StopCase run_stop_case(std::uint64_t seed, std::optional<DeviceFault> fault,
                                     const Hardness& hardness = {});

}  // namespace tonus::testing
