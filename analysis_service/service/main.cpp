// tonus-identification: judges every trial by what was measured and identifies the arm's impedance as it
// comes.

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "analysis_service/service/command_line.hpp"
#include "analysis_service/service/service.hpp"
#include "services/core/lifetime.hpp"
#include "services/runtime/loop.hpp"
#include "services/runtime/options.hpp"

int main(int argc, char** argv) {
  using namespace tonus;
  runtime::begin_program();
  const std::string program = "tonus-identification";
  const auto notifier = std::make_shared<bus::Notifier>();
  const StopSignal stop([notifier] { notifier->notify(); });

  CLI::App app("Judges trials and identifies impedance as samples arrive.", program);
  runtime::CommonOptions common;
  identification::CommandLine command_line;
  runtime::add_common_options(app, common);
  command_line.add_to(app);
  runtime::set_example(app, "tonus-identification --method state_variable");
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  runtime::start_log(program, common);

  const auto settings = command_line.settings(common.rig);
  if (!settings) return runtime::report(program, settings.error());
  auto bus = runtime::open_bus(common, program);
  if (!bus) return runtime::report(program, bus.error());
  auto endpoints = identification::ServiceEndpoints::create(**bus, notifier);
  if (!endpoints) return runtime::report(program, endpoints.error());
  const SystemClock clock;
  auto health = runtime::HealthReporter::create(**bus, clock, v1::ROLE_IDENTIFICATION, common, notifier);
  if (!health) return runtime::report(program, health.error());
  if (auto alone = runtime::listen_for_others(*health, common, clock, *notifier, stop); !alone)
    return runtime::report(program, alone.error());
  auto roster = runtime::Roster::create(**bus, clock, notifier);
  if (!roster) return runtime::report(program, roster.error());

  identification::IdentificationService service(*settings, std::move(*endpoints), std::move(*health),
                                                std::move(*roster), clock);
  const auto ended = runtime::run_loop_until_error(*notifier, stop, [&]() -> Result<Clock::TimePoint> {
    TONUS_TRY(service.check_alone());
    return service.step();
  });
  if (!ended) return runtime::report(program, ended.error());
  service.finish();
  return 0;
}
