#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rig_agent/control/fault.hpp"
#include "rig_agent/control/flight_recorder.hpp"
#include "rig_agent/control/safety_limits.hpp"
#include "rig_agent/control/sample_record.hpp"
#include "rig_agent/control/trial_program.hpp"
#include "services/core/id.hpp"
#include "services/mechanics/auxiliary_channel.hpp"
#include "services/mechanics/rig_geometry.hpp"

#include <idl/rig.h>
#include <idl/trial.h>

/// Where the rig's own types meet the wire's. Pure.
namespace tonus::rig {

/// Names of the rig that its geometry does not hold.
struct RigNames {
  Id id{};
  std::string name;
  std::string driver;
  double loop_rate = 0.0;                          ///< Hz
  double sample_rate = 0.0;                        ///< Hz
  Eigen::Vector2d home = Eigen::Vector2d::Zero();  ///< m, handle in R between trials
  std::string displacement_unit = "m";
  std::string force_unit = "N";
  std::string calibrated_at;  ///< ISO 8601, empty if never
  std::string calibrated_by;
  std::string calibration_toml;  ///< The calibration's steps with their readings
  bool moves_nothing_real = false;
  bool resumes_unattended = false;
  double watchdog = 0.0;  ///< s without a cycle after which the watchdog drops the torque; 0: none
  std::vector<std::string> limits_off;          ///< Names of limits that are switched off
  std::optional<control::SafetyLimits> limits;  ///< Of a driver that actuates
  std::vector<AuxiliaryChannel> auxiliary_channels;
  bool marks_onset = false;
};

[[nodiscard]] v1::RigDescription describe(const RigNames& names, const RigGeometry& geometry);

/// `number` is what the loop echoes in samples and result; not 0.
[[nodiscard]] control::TrialProgram to_program(const v1::TrialProgram& wire, std::uint64_t number);

[[nodiscard]] v1::RigSample to_wire(const control::SampleRecord& record);

[[nodiscard]] v1::FlightCycle to_wire(const control::CycleRecord& record);

[[nodiscard]] v1::TrialEnd to_wire(control::TrialOutcome outcome);

}  // namespace tonus::rig
