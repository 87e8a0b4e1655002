// tonus-archive: keeps every raw sample and every message that matters, and proves that they are complete.

#include <memory>
#include <spdlog/spdlog.h>
#include <string>

#include "services/archive/archive_service.hpp"
#include "services/archive/open_store.hpp"
#include "services/core/lifetime.hpp"
#include "services/runtime/health.hpp"
#include "services/runtime/loop.hpp"
#include "services/runtime/options.hpp"

namespace tonus {
namespace {

constexpr char kProgram[] = "tonus-archive";

Result<void> run(const runtime::CommonOptions& common, std::string store_name) {
  const auto notifier = std::make_shared<bus::Notifier>();
  const StopSignal stop([notifier] { notifier->notify(); });
  const SystemClock clock;

  if (store_name.empty()) {
    const auto folder = runtime::data_folder(common);
    if (!folder) return folder.error();
    store_name = (*folder / "archive.sqlite").string();
  }
  const auto store = archive::open_store_for_writing(store_name);
  if (!store) return store.error();
  archive::Ingest ingest(**store, clock);
  if (auto recovered = ingest.recover(); !recovered) return recovered;

  const auto bus = runtime::open_bus(common, kProgram);
  if (!bus) return bus.error();
  const auto service = archive::ArchiveService::create(**bus, ingest, clock, notifier);
  if (!service) return service.error();
  auto health = runtime::HealthReporter::create(**bus, clock, v1::ROLE_ARCHIVE, common);
  if (!health) return health.error();
  spdlog::info("store '{}'", store_name);

  runtime::run_loop(*notifier, stop, [&] {
    const auto due = (*service)->step();
    const auto status = ingest.status();
    const std::string why = (*service)->why_not_ready();
    health->set_state(why.empty(), why.empty() ? "stores to " + store_name : why);
    health->set_load((*service)->lag(), static_cast<std::uint32_t>(status.waiting_items),
                     (*service)->dropped());
    return std::min(due, health->publish_if_due());
  });
  return ingest.finish();
}

}  // namespace
}  // namespace tonus

int main(int argc, char** argv) {
  using namespace tonus;
  CLI::App app("Keeps every sample and message of the sessions, durably.", kProgram);
  runtime::CommonOptions common;
  std::string store_name;
  runtime::add_common_options(app, common);
  app.add_option(
      "--store", store_name,
      "file of the study, or :memory: to keep nothing (default: archive.sqlite in the data folder)");
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  runtime::start_log(kProgram, common.log_level);
  const auto outcome = run(common, store_name);
  return outcome ? 0 : runtime::report(kProgram, outcome.error());
}
