#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <toml++/toml.h>

#include "rig_agent/control/rig_loop.hpp"
#include "services/config/checked_table.hpp"
#include "services/core/result.hpp"
#include "services/simulation/plant_profile.hpp"

namespace tonus::simulation {

/// A simulated rig with its subject, and the loop that runs it: everything that a profile file says.
struct Profile : PlantProfile {
  double loop_rate = 1000.0;
  unsigned sample_divider = 5;
  control::SafetyLimits limits;
  control::ServoGains gains;
};

/// Reads a profile (TOML, keys with their unit: deploy/profiles/default.toml has them all). What the text
/// does not say keeps its default. Refuses unknown keys, wrong types and values out of their limits with one
/// line, "source:line: key: value is not allowed; expected limits".
[[nodiscard]] Result<Profile> parse_profile(std::string_view text, std::string_view source);
/// The same of a table that is parsed already.
[[nodiscard]] Result<Profile> read_profile(const toml::table& table, const std::string& source);
/// Every key of a profile, as parse_profile() checks it.
[[nodiscard]] std::vector<config::Key> profile_keys();
[[nodiscard]] Result<Profile> load_profile(const std::filesystem::path& file);

/// Rate, limits, gains and model for the loop that runs this rig.
[[nodiscard]] control::LoopConfig loop_config(const Profile& profile);

}  // namespace tonus::simulation
