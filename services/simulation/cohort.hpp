#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"
#include "services/simulation/profile.hpp"

namespace tonus::simulation {

/// One subject of a cohort: the whole simulated rig with this subject at it.
struct CohortSubject {
  std::string name;
  Profile profile;
  std::string profile_toml;  ///< The same as a profile file.
};

/// Reads a cohort (TOML, deploy/profiles/cohort.toml): [common] is a profile, each [[subject]] adds the keys
/// of a profile's [subject], a name, and instead of a joint damping optionally `damping_time_s`, from which
/// the elements of the joint damping matrix follow: B11 = shoulder K11, B22 = elbow K22, B12 = two_joint K12,
/// so that, with (21), the muscle groups have d = two_joint K12, s = B11 - d, e = B22 - d.
/// Refusals as parse_profile's, and for names that are missing or not unique.
[[nodiscard]] Result<std::vector<CohortSubject>> parse_cohort(std::string_view text, std::string_view source);
/// The keys that a cohort has beside those of a profile.
[[nodiscard]] std::vector<config::Key> cohort_keys();
[[nodiscard]] Result<std::vector<CohortSubject>> load_cohort(const std::filesystem::path& file);

}  // namespace tonus::simulation
