// tonus-archive: keeps every raw sample and every message that matters, and proves that they are complete.

#include <CLI/CLI.hpp>
#include <memory>
#include <spdlog/fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <string>
#include <utility>

#include "services/archive/archive_run.hpp"
#include "services/core/lifetime.hpp"
#include "services/runtime/health.hpp"
#include "services/runtime/loop.hpp"
#include "services/runtime/options.hpp"
#include "services/store/open_store.hpp"

namespace tonus {
namespace {

constexpr char kProgram[] = "tonus-archive";
constexpr std::chrono::seconds kOpenAgain{1};

struct Options {
  runtime::CommonOptions common;
  std::string store;
  std::uint64_t limit_MB = 0;
  std::uint64_t reserve_MB = 1000;
  std::uint32_t idle_ring_s = 60;
  bool upgrades_schema = false;

  [[nodiscard]] archive::DiskBudget::Options disk() const {
    archive::DiskBudget::Options disk;
    if (limit_MB > 0) disk.limit_bytes = limit_MB * 1'000'000;
    disk.reserve_bytes = reserve_MB * 1'000'000;
    return disk;
  }
};

/// Opens the store; while it cannot be opened for a reason that may pass, the health names the reason and it
/// is tried again. The error is that of the last try: of a name that is not allowed, or at the stop.
Result<std::unique_ptr<store::Store>> open_store(const std::string& name, runtime::HealthReporter& health,
                                                 bus::Notifier& notifier, const StopSignal& stop,
                                                 const Clock& clock) {
  std::string reason;
  while (true) {
    auto store = store::open_store_for_writing(name);
    if (store || store.error().code == ErrorCode::kInvalidArgument || stop.is_requested()) return store;
    if (reason != store.error().message) spdlog::error("{}", store.error().message);
    reason = store.error().message;
    health.set_state(false, reason);
    const auto again = clock.now() + kOpenAgain;
    while (!stop.is_requested() && clock.now() < again)
      (void)notifier.wait_until(std::min(again, health.publish_if_due()));
  }
}

/// An older archive's tables are changed only by a person who has seen what is done.
Result<void> check_upgrade(const std::string& name, bool is_allowed) {
  const auto steps = store::pending_upgrade(name);
  if (!steps || steps->empty()) return {};  // what else is wrong shows when it is opened
  const std::string what = fmt::format("store '{}': its tables are older; they would be brought to {}", name,
                                       fmt::join(*steps, ", then to "));
  if (!is_allowed) {
    return fail(
        ErrorCode::kInvalidArgument,
        what + ". Keep a copy of the file, which older programs read, and start with --upgrade-schema");
  }
  spdlog::warn("{}, as --upgrade-schema allows", what);
  return {};
}

/// What is still on its way when the archive is told to end: until nothing has come for a while.
void take_the_rest(archive::ArchiveRun& archive, bus::Notifier& notifier, const Clock& clock) {
  constexpr std::chrono::milliseconds kQuiet{100};
  constexpr std::chrono::milliseconds kLimit{500};
  const auto limit = clock.now() + kLimit;
  auto quiet = clock.now() + kQuiet;
  while (clock.now() < std::min(quiet, limit)) {
    const auto taken = archive.taken();
    const auto due = archive.take_the_rest();
    if (archive.taken() != taken) quiet = clock.now() + kQuiet;
    (void)notifier.wait_until(std::min({due, quiet, limit}));
  }
}

Result<void> run(const Options& options) {
  const auto notifier = std::make_shared<bus::Notifier>();
  const StopSignal stop([notifier] { notifier->notify(); });
  const SystemClock clock;

  std::string store_name = options.store;
  if (store_name.empty()) {
    TONUS_TRY_ASSIGN(const auto folder, runtime::data_folder(options.common));
    store_name = store::default_store(folder).string();
  }
  TONUS_TRY(check_upgrade(store_name, options.upgrades_schema));
  TONUS_TRY_ASSIGN(const auto bus, runtime::open_bus(options.common, kProgram));
  TONUS_TRY_ASSIGN(auto health,
                   runtime::HealthReporter::create(*bus, clock, v1::ROLE_ARCHIVE, options.common, notifier));
  TONUS_TRY(runtime::listen_for_others(health, options.common, clock, *notifier, stop));
  const auto store = open_store(store_name, health, *notifier, stop, clock);
  if (!store) return store.error();
  archive::ArchiveRun::Options run_options;
  run_options.ingest.idle.ring = std::chrono::seconds(options.idle_ring_s);
  run_options.disk = options.disk();
  TONUS_TRY_ASSIGN(const auto archive, archive::ArchiveRun::create(*bus, **store, clock, notifier,
                                                                   std::move(health), run_options));
  spdlog::info("store '{}'", (*store)->name());

  auto ended = runtime::run_loop_until_error(*notifier, stop, [&] { return archive->step(); });
  if (ended) take_the_rest(*archive, *notifier, clock);
  TONUS_TRY(archive->finish());
  return ended;
}

}  // namespace
}  // namespace tonus

int main(int argc, char** argv) {
  using namespace tonus;
  runtime::begin_program();
  CLI::App app("Keeps every sample and message of the sessions, durably.", kProgram);
  Options options;
  runtime::add_common_options(app, options.common);
  app.add_option("--store", options.store,
                 "file of the study, postgresql://USER@HOST/DATABASE, or :memory: to keep nothing "
                 "(default: archive.sqlite in the data folder)");
  app.add_option("--limit-MB", options.limit_MB,
                 "most that the store may take; sessions wait or pause before (0: what its disk has)")
      ->capture_default_str();
  app.add_option("--reserve-MB", options.reserve_MB,
                 "what stays free on the store's disk; sessions wait or pause before")
      ->capture_default_str();
  app.add_flag("--upgrade-schema", options.upgrades_schema,
               "change the tables of an archive that an older version wrote; without it they are only named");
  app.add_option("--idle-ring-s", options.idle_ring_s,
                 "outside of sessions, how long samples wait in memory for a fault before they are let go, s "
                 "(0: every sample is stored)")
      ->check(CLI::Range(0, 3600))
      ->capture_default_str();
  runtime::set_example(app, "tonus-archive --data /var/lib/tonus");
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  runtime::start_log(kProgram, options.common);
  const auto outcome = run(options);
  return runtime::end_program(kProgram, outcome ? 0 : runtime::report(kProgram, outcome.error()));
}
