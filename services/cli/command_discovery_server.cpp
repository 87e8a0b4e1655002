#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "services/bus/discovery_server.hpp"
#include "services/cli/commands.hpp"
#include "services/core/clock.hpp"
#include "services/core/lifetime.hpp"
#include "services/runtime/network.hpp"
#include "services/runtime/options.hpp"

namespace tonus::cli {
namespace {

Result<void> serve(const runtime::CommonOptions& common, std::uint16_t port) {
  const auto notifier = std::make_shared<bus::Notifier>();
  const StopSignal stop([notifier] { notifier->notify(); });
  if (!common.security.empty())
    return fail(ErrorCode::kInvalidArgument,
                "--security: a secured domain has no discovery server; expected --peers");
  bus::BusOptions options;
  TONUS_TRY_ASSIGN(options.vendor, bus::parse_vendor(common.dds));
  TONUS_TRY_ASSIGN(options.network, runtime::network_profile(common));
  options.domain = common.domain;
  options.participant_name = "tonus discovery-server";
  TONUS_TRY_ASSIGN(const auto server, bus::DiscoveryServer::start(options, port));
  std::printf("discovery server of domain %d at %s:%u\n", common.domain,
              options.network.interface_address.c_str(), static_cast<unsigned>(port));
  std::fflush(stdout);
  while (!stop.is_requested()) (void)notifier->wait_until(Clock::TimePoint::max());
  return {};
}

}  // namespace

void add_discovery_server_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand(
      "discovery-server", "Tells programs on several hosts (fastdds) where the others are, until Ctrl-C.");
  auto common = std::make_shared<runtime::CommonOptions>();
  auto port = std::make_shared<std::uint16_t>(bus::DiscoveryServerAddress{}.port);
  runtime::add_common_options(*command, *common);
  command->add_option("--port", *port, "UDP port that it listens on")
      ->check(CLI::Range(1024, 65535))
      ->capture_default_str();
  command->callback([common, port, &chosen] {
    chosen = [common, port] {
      runtime::start_log("tonus discovery-server", common->log_level);
      const auto served = serve(*common, *port);
      return served ? 0 : runtime::report("tonus discovery-server", served.error());
    };
  });
}

}  // namespace tonus::cli
