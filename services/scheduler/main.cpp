// tonus-scheduler: turns a protocol into trials, one at a time, from what was measured.

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "services/core/lifetime.hpp"
#include "services/runtime/options.hpp"
#include "services/scheduler/scheduler_service.hpp"

#include <idl/idl_hash.hpp>

int main(int argc, char** argv) {
  using namespace tonus;
  runtime::begin_program();
  const std::string program = "tonus-scheduler";
  const auto notifier = std::make_shared<bus::Notifier>();
  const StopSignal stop([notifier] { notifier->notify(); });

  CLI::App app("Runs sessions: one trial after the other, each counted once.", program);
  runtime::CommonOptions common;
  runtime::add_common_options(app, common);
  runtime::set_example(app, "tonus-scheduler --rig left");
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  runtime::start_log(program, common);

  const auto data = runtime::data_folder(common);
  if (!data) return runtime::report(program, data.error());
  auto folder = scheduler::SessionFolder::open(*data / "sessions", v1::kIdlHash);
  if (!folder) return runtime::report(program, folder.error());
  auto bus = runtime::open_bus(common, program);
  if (!bus) return runtime::report(program, bus.error());
  const SystemClock clock;
  auto endpoints = scheduler::SchedulerEndpoints::create(**bus, notifier);
  if (!endpoints) return runtime::report(program, endpoints.error());
  auto health = runtime::HealthReporter::create(**bus, clock, v1::ROLE_SCHEDULER, common, notifier);
  if (!health) return runtime::report(program, health.error());
  if (auto alone = runtime::listen_for_others(*health, common, clock, *notifier, stop); !alone)
    return runtime::report(program, alone.error());
  auto roster = runtime::Roster::create(**bus, clock, notifier);
  if (!roster) return runtime::report(program, roster.error());
  auto lease_bus = runtime::open_bus(common, program + " lease");
  if (!lease_bus) return runtime::report(program, lease_bus.error());
  auto lease = scheduler::LeaseSender::create(std::move(*lease_bus), clock);
  if (!lease) return runtime::report(program, lease.error());
  auto service =
      scheduler::SchedulerService::create(std::move(*endpoints), std::move(*health), std::move(*roster),
                                          std::move(*folder), std::move(*lease), common.rig, clock);
  if (!service) return runtime::report(program, service.error());

  while (true) {
    const auto due = (*service)->step();
    if (!due) return runtime::report(program, due.error());
    if (stop.is_requested()) return 0;
    (void)notifier->wait_until(*due);
  }
}
