// tonus-identification: judges every trial by what was measured and identifies the arm's impedance as it
// comes, of one rig or of several.

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "analysis_service/service/command_line.hpp"
#include "analysis_service/service/rigs_service.hpp"
#include "services/core/lifetime.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/rigs.hpp"

namespace tonus {
namespace {

constexpr char kProgram[] = "tonus-identification";

/// Of each rig, all at the same time: listening takes seconds.
Result<void> listen_for_others(std::vector<identification::RigParts>& parts,
                               const std::vector<runtime::CommonOptions>& rigs, const Clock& clock,
                               const StopSignal& stop) {
  std::vector<Result<void>> heard(rigs.size());
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < rigs.size(); ++i) {
      threads.emplace_back([&, i] {
        heard[i] = runtime::listen_for_others(parts[i].health, rigs[i], clock, *parts[i].notifier, stop);
      });
    }
  }
  for (const auto& each : heard) TONUS_TRY(each);
  return {};
}

Result<void> run(const runtime::CommonOptions& common, const std::vector<std::string>& names,
                 const identification::CommandLine& command_line) {
  const auto notifier = std::make_shared<bus::Notifier>();
  const StopSignal stop([notifier] { notifier->notify(); });
  TONUS_TRY_ASSIGN(const auto rigs, runtime::each_rig(common, names));
  TONUS_TRY_ASSIGN(const auto buses, runtime::open_buses(rigs, kProgram));
  const SystemClock clock;
  std::vector<identification::RigParts> parts;
  for (std::size_t i = 0; i < rigs.size(); ++i) {
    TONUS_TRY_ASSIGN(auto settings, command_line.settings(rigs[i].rig));
    settings.served = runtime::rigs_text(rigs);
    TONUS_TRY_ASSIGN(auto part, identification::RigParts::create(*buses[i], clock, rigs[i], settings));
    parts.push_back(std::move(part));
  }
  TONUS_TRY(listen_for_others(parts, rigs, clock, stop));

  identification::RigsService service(std::move(parts), clock, notifier);
  while (!stop.is_requested() && !service.has_failed())
    (void)notifier->wait_until(clock.now() + std::chrono::hours(1));
  return service.finish();
}

}  // namespace
}  // namespace tonus

int main(int argc, char** argv) {
  using namespace tonus;
  runtime::begin_program();
  CLI::App app("Judges trials and identifies impedance as samples arrive.", kProgram);
  runtime::CommonOptions common;
  std::vector<std::string> rigs;
  identification::CommandLine command_line;
  runtime::add_common_options(app, common);
  runtime::add_rigs_option(app, rigs);
  command_line.add_to(app);
  runtime::set_example(app, "tonus-identification --method state_variable");
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  runtime::start_log(kProgram, common);
  const auto ended = run(common, rigs, command_line);
  return ended ? 0 : runtime::report(kProgram, ended.error());
}
