#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "services/cli/commands.hpp"
#include "services/cli/operator_connection.hpp"
#include "services/cli/system.hpp"

namespace tonus::cli {
namespace {

constexpr char kName[] = "tonus up";

/// Says where the pages are.
Result<void> tell_dashboard(OperatorConnection& op, System& system) {
  const auto health = [&op] { return op.client().roster().find(v1::ROLE_DASHBOARD); };
  const auto deadline = op.clock().now() + kRosterLimit;
  while (!op.client().wait_for([&] { return health() && health()->is_ready(); },
                               std::chrono::milliseconds(100), [&op] { return op.is_interrupted(); })) {
    if (auto kept = system.supervise(kName); !kept) return kept;
    if (op.is_interrupted() || op.clock().now() > deadline)
      return fail(ErrorCode::kTimeout, "dashboard did not become ready");
  }
  std::printf("dashboard %s\n", health()->state().c_str());
  return {};
}

Result<void> up(const SystemOptions& options) {
  auto end = OperatorConnection::join(options.common);
  if (!end) return end.error();
  OperatorConnection& op = **end;
  const auto begun = op.clock().now();
  auto system = System::start(options, op.clock());
  if (!system) return system.error();
  auto complete = op.wait_for_roster([&] { return system->supervise(kName); });
  if (!complete && op.held().empty()) return complete;  // a held rig waits for its operator
  std::printf(
      "ready after %.1f s: rig, scheduler, identification, archive in domain %d over %s; data in %s\n",
      std::chrono::duration<double>(op.clock().now() - begun).count(), options.common.domain,
      options.common.dds.c_str(), system->data().c_str());
  if (const std::string held = op.held(); !held.empty()) std::printf("%s\n", held.c_str());
  if (options.has_dashboard) {
    if (auto told = tell_dashboard(op, *system); !told) return told;
  }
  std::fflush(stdout);
  while (!op.is_interrupted()) {
    (void)op.client().wait_for([] { return false; }, std::chrono::milliseconds(100),
                               [&] { return op.is_interrupted(); });
    if (auto kept = system->supervise(kName); !kept) return kept;
  }
  std::printf("stopping\n");
  return {};
}

}  // namespace

void add_up_command(CLI::App& app, Command& chosen) {
  auto* command =
      app.add_subcommand("up", "Starts the services on this machine and keeps them running until Ctrl-C.");
  auto options = std::make_shared<SystemOptions>();
  add_system_options(*command, *options);
  command->callback([options, &chosen] {
    chosen = [options] {
      runtime::start_log(kName, options->common);
      const auto outcome = up(*options);
      return outcome ? 0 : runtime::report(kName, outcome.error());
    };
  });
}

}  // namespace tonus::cli
