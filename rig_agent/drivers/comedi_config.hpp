#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/config/checked_table.hpp"
#include "services/core/result.hpp"

namespace tonus::drivers {

/// A channel of a card: numbers as Comedi counts them.
struct ComediChannel {
  unsigned subdevice = 0;
  unsigned channel = 0;
  unsigned range = 0;      ///< Index among the channel's ranges.
  unsigned reference = 0;  ///< AREF_GROUND 0, AREF_COMMON 1, AREF_DIFF 2, AREF_OTHER 3.
};

/// The analogue input of an auxiliary channel; what is measured there, the rig's profile says
/// (`[[auxiliary]]`).
struct ComediAuxiliary {
  std::string name;  ///< The channel's in the profile.
  ComediChannel input;
};

/// What is connected to a card. Two channels each: inner and outer joint, the sensor's x and y axis.
struct ComediConfig {
  std::string device = "/dev/comedi0";
  std::array<ComediChannel, 2> encoders;  ///< Counters.
  std::optional<unsigned> counter_mode;   ///< Sets the counters up at the start; none: somebody else has, and
                                          ///< their counts are kept.
  std::array<ComediChannel, 2> force;     ///< Analogue inputs.
  std::array<ComediChannel, 2> motors;    ///< Analogue outputs to the torque inputs of the amplifiers.
  std::array<double, 2> torque_per_volt{1.0, 1.0};  ///< N m/V; negative where the motor turns the other way.
  std::optional<ComediChannel> emergency_stop;      ///< Digital input.
  /// Digital output that enables the amplifiers while it is high: a broken wire takes the torque away.
  std::optional<ComediChannel> enable;
  /// Digital output that changes in every cycle, for a circuit that takes the enable away when it stands
  /// still.
  std::optional<ComediChannel> heartbeat;
  std::optional<ComediChannel> onset;  ///< Digital output that is high during a perturbation.
  std::vector<ComediAuxiliary> auxiliary;
  bool is_pressed_when_high = true;  ///< A broken wire should read as pressed: wire it so.
};

/// The table [comedi] of a TOML file; rig_agent/drivers/README.md has all keys. Refuses unknown keys, missing
/// ones and values out of their limits with one line that names the source, the key and what is allowed.
/// Every key of it, as parse_comedi_config() checks it.
[[nodiscard]] std::vector<config::Key> comedi_keys();
[[nodiscard]] Result<ComediConfig> parse_comedi_config(std::string_view text, const std::string& source);
[[nodiscard]] Result<ComediConfig> load_comedi_config(const std::filesystem::path& file);

}  // namespace tonus::drivers
