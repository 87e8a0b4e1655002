#include "services/bus/vendor_environment.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace tonus::bus {
namespace {

/// FASTDDS_ENVIRONMENT_FILE, FASTDDS_STATISTICS, FASTRTPS_DEFAULT_PROFILES_FILE, CYCLONEDDS_URI, and what
/// later versions add to their names.
constexpr std::array<std::string_view, 3> kPrefixes{"FASTDDS_", "FASTRTPS_", "CYCLONEDDS_"};
constexpr std::string_view kDiscoveryServer = "ROS_DISCOVERY_SERVER";
constexpr const char* kNoProfilesOfTheFolder = "SKIP_DEFAULT_XML_FILE";

bool is_of_a_vendor(std::string_view name) {
  return name == kDiscoveryServer ||
         std::ranges::any_of(kPrefixes, [name](std::string_view prefix) { return name.starts_with(prefix); });
}

std::vector<std::string> names_of_vendors() {
  std::vector<std::string> names;
  for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const std::string_view name = text.substr(0, text.find('='));
    if (is_of_a_vendor(name)) names.emplace_back(name);
  }
  return names;
}

}  // namespace

void ignore_vendor_environment() {
  for (const std::string& name : names_of_vendors()) unsetenv(name.c_str());
  const char* skipped = std::getenv(kNoProfilesOfTheFolder);
  if (skipped == nullptr || std::string_view(skipped) != "1") setenv(kNoProfilesOfTheFolder, "1", 1);
}

}  // namespace tonus::bus
