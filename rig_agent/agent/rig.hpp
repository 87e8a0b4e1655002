#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "rig_agent/agent/recorded_trials.hpp"
#include "rig_agent/agent/wire.hpp"
#include "rig_agent/calibration/calibration.hpp"
#include "rig_agent/control/realtime_setup.hpp"
#include "rig_agent/control/rig_loop.hpp"
#include "rig_agent/drivers/driver.hpp"
#include "services/core/result.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::rig {

/// What the command line says of the hardware.
struct RigOptions {
  std::string driver = "simulated";
  std::string profile;      ///< TOML file of the rig, and of the simulated subject; empty: the built-in one.
  std::string driver_file;  ///< The shared library, or the TOML file of the comedi driver.
  std::string driver_options;  ///< Handed to the shared library.
  std::string dataset;         ///< BIDS dataset of the replay driver.
  int force_sign = 0;          ///< Of a one-axis dataset that does not state it; 0: not said.
  std::optional<std::uint64_t> seed;
  std::string speed = "real";
  int spool_MB = 4096;
  std::string folder;  ///< For calibration and hold; empty: see own_folder().
  bool resumes_unattended = false;
  int fifo_priority = 80;       ///< 0: leaves the scheduling alone.
  std::optional<int> loop_cpu;  ///< The loop's processor.

  [[nodiscard]] bool is_paced() const { return speed == "real"; }
  [[nodiscard]] control::RealtimeRequest realtime() const;
  /// The folder for the rig's calibration and hold: as it was said, else the machine's for a rig that may
  /// move something real, else empty: in the data folder. kUnavailable where no place is known.
  [[nodiscard]] Result<std::filesystem::path> own_folder(const std::string& rig) const;
};

void add_options(CLI::App& app, RigOptions& options);

/// The one place that knows which hardware there is: a driver, ready and active, with the loop over it.
class Rig {
 public:
  /// What `calibration` (a file, may be absent) holds corrects the driver's geometry; a recording has its
  /// own.
  [[nodiscard]] static Result<Rig> create(const RigOptions& options, const std::string& name,
                                          const std::filesystem::path& calibration = {});

  [[nodiscard]] drivers::Driver& driver() { return *driver_; }
  [[nodiscard]] control::RigLoop& loop() { return *loop_; }
  [[nodiscard]] RecordedTrials* recorded() {
    return recorded_.get();
  }  ///< Null for all but a replayed dataset.
  [[nodiscard]] const RigNames& names() const { return names_; }
  [[nodiscard]] const calibration::Calibration& calibration() const { return calibration_; }

 private:
  explicit Rig(const std::string& driver) : calibration_(driver) {}
  [[nodiscard]] Result<control::LoopConfig> open_simulated(const RigOptions& options);
  [[nodiscard]] Result<control::LoopConfig> open_library(const RigOptions& options);
  [[nodiscard]] Result<control::LoopConfig> open_comedi(const RigOptions& options);
  [[nodiscard]] Result<control::LoopConfig> open_replay(const RigOptions& options);
  [[nodiscard]] Result<control::LoopConfig> open(const RigOptions& options);
  [[nodiscard]] Result<void> calibrate(const std::filesystem::path& file);

  RigNames names_;
  calibration::Calibration calibration_;
  std::unique_ptr<RecordedTrials> recorded_;
  std::unique_ptr<drivers::Driver> driver_;
  std::unique_ptr<control::RigLoop> loop_;
};

}  // namespace tonus::rig
