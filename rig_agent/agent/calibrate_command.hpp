#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "rig_agent/agent/rig.hpp"
#include "rig_agent/agent/rig_folder.hpp"
#include "services/core/clock.hpp"
#include "services/core/result.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::rig {

/// What `tonus-rig-agent calibrate ...` is told.
struct CalibrateOptions {
  std::string by;
  double time = 2.0;                ///< s of reading at rest.
  std::vector<double> place;        ///< zero: m in R; empty: `joints` are given.
  std::vector<double> joints;       ///< zero: deg.
  std::vector<double> load;         ///< force: N in R, pull on the handle.
  bool is_anew = false;             ///< force: forgets the loads before.
  double nominal = 0.0;             ///< spring: N/m.
  std::optional<double> direction;  ///< spring: deg in R; none: the mean of all.
  double tolerance_percent = 5.0;
};

/// A step of the calibration on a rig whose folder is taken: does it, writes the file, and returns a line for
/// a person. A spring out of tolerance is an error, and is written all the same.
using CalibrationStep = std::function<Result<std::string>(
    Rig& rig, const RigFolder& folder, const CalibrateOptions& options, const Clock& clock)>;

[[nodiscard]] Result<std::string> tare(Rig& rig, const RigFolder& folder, const CalibrateOptions& options,
                                       const Clock& clock);
[[nodiscard]] Result<std::string> find_zero(Rig& rig, const RigFolder& folder,
                                            const CalibrateOptions& options, const Clock& clock);
[[nodiscard]] Result<std::string> calibrate_force(Rig& rig, const RigFolder& folder,
                                                  const CalibrateOptions& options, const Clock& clock);
[[nodiscard]] Result<std::string> check_spring(Rig& rig, const RigFolder& folder,
                                               const CalibrateOptions& options, const Clock& clock);

/// Adds the command `calibrate` with its steps to the agent's command line; `chosen` is set by parsing.
void add_calibrate_command(CLI::App& app, CalibrateOptions& options, CalibrationStep& chosen);

}  // namespace tonus::rig
