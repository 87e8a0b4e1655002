#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "rig_agent/agent/recorded_trials.hpp"
#include "rig_agent/agent/wire.hpp"
#include "rig_agent/control/rig_loop.hpp"
#include "rig_agent/drivers/driver.hpp"
#include "services/core/result.hpp"

namespace tonus::rig {

/// What the command line says of the hardware.
struct RigOptions {
  std::string driver = "simulated";
  std::string profile;  ///< TOML file of the simulated rig and subject; empty: the built-in one.
  std::string dataset;  ///< BIDS dataset of the replay driver.
  int force_sign = 0;   ///< Of a one-axis dataset that does not state it; 0: not said.
  std::optional<std::uint64_t> seed;
  std::string speed = "real";
  int spool_MB = 4096;

  [[nodiscard]] bool is_paced() const { return speed == "real"; }
};

void add_options(CLI::App& app, RigOptions& options);

/// The one place that knows which hardware there is: a driver, ready and active, with the loop over it.
class Rig {
 public:
  [[nodiscard]] static Result<Rig> create(const RigOptions& options, const std::string& name);

  [[nodiscard]] drivers::Driver& driver() { return *driver_; }
  [[nodiscard]] control::RigLoop& loop() { return *loop_; }
  [[nodiscard]] RecordedTrials* recorded() {
    return recorded_.get();
  }  ///< Null for all but a replayed dataset.
  [[nodiscard]] const RigNames& names() const { return names_; }

 private:
  Rig() = default;
  [[nodiscard]] Result<control::LoopConfig> open_simulated(const RigOptions& options);
  [[nodiscard]] Result<control::LoopConfig> open_replay(const RigOptions& options);

  RigNames names_;
  std::unique_ptr<RecordedTrials> recorded_;
  std::unique_ptr<drivers::Driver> driver_;
  std::unique_ptr<control::RigLoop> loop_;
};

}  // namespace tonus::rig
