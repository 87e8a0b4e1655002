#include "services/runtime/rigs.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <spdlog/fmt/fmt.h>

#include "services/core/name.hpp"
#include "services/runtime/network.hpp"
#include "services/runtime/security.hpp"

namespace tonus::runtime {

void add_rigs_option(CLI::App& app, std::vector<std::string>& rigs) {
  app.add_option("--rigs", rigs,
                 "names of the rigs that this process serves, with commas between (default: that of --rig)")
      ->delimiter(',')
      ->check(CLI::Validator([](const std::string& name) { return fault_of_name(name); }, ""));
}

Result<std::vector<CommonOptions>> each_rig(const CommonOptions& common,
                                            const std::vector<std::string>& rigs) {
  if (rigs.empty()) return std::vector<CommonOptions>{common};
  if (rigs.size() > kMostRigs) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("--rigs: {} names are not allowed; expected at most {}", rigs.size(), kMostRigs));
  }
  std::vector<CommonOptions> all;
  for (const std::string& name : rigs) {
    if (std::any_of(all.begin(), all.end(), [&](const CommonOptions& known) { return known.rig == name; }))
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("--rigs: '{}' twice is not allowed; expected each rig once", name));
    all.push_back(common);
    all.back().rig = name;
  }
  return all;
}

std::string rigs_text(const std::vector<CommonOptions>& rigs) {
  constexpr std::size_t kMostNamed = 8;
  if (rigs.size() < 2) return {};
  if (rigs.size() > kMostNamed) return fmt::format("{} rigs", rigs.size());
  std::string text;
  for (const CommonOptions& each : rigs) text += (text.empty() ? "" : ", ") + each.rig;
  return text;
}

Result<bus::BusOptions> bus_options_of(const CommonOptions& options, const std::string& program) {
  bus::BusOptions bus_options;
  TONUS_TRY_ASSIGN(bus_options.vendor, bus::parse_vendor(options.dds));
  bus_options.domain = options.domain;
  bus_options.participant_name = program;
  TONUS_TRY_ASSIGN(bus_options.network, network_profile(options));
  TONUS_TRY_ASSIGN(bus_options.security, security_files(options, program));
  if (bus_options.security)
    TONUS_TRY(check_certificate(*bus_options.security, std::chrono::system_clock::now()));
  return bus_options;
}

Result<std::vector<std::unique_ptr<bus::Bus>>> open_buses(const std::vector<CommonOptions>& rigs,
                                                          const std::string& program) {
  TONUS_TRY_ASSIGN(const auto options, bus_options_of(rigs.front(), program));
  std::vector<bus::Partitions> places;
  places.reserve(rigs.size());
  for (const CommonOptions& each : rigs) places.push_back({each.rig});
  return bus::create_buses(options, places);
}

}  // namespace tonus::runtime
