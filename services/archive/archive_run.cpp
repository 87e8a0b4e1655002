#include "services/archive/archive_run.hpp"

#include <algorithm>
#include <utility>

namespace tonus::archive {

ArchiveRun::ArchiveRun(store::Store& store, const Clock& clock, runtime::HealthReporter health,
                       const Options& options)
    : store_(store),
      health_(std::move(health)),
      ingest_(store, clock, options.ingest),
      disk_(store, clock, options.disk) {}

Result<std::unique_ptr<ArchiveRun>> ArchiveRun::create(bus::Bus& bus, store::Store& store, const Clock& clock,
                                                       std::shared_ptr<bus::Notifier> notifier,
                                                       runtime::HealthReporter health,
                                                       const Options& options) {
  std::unique_ptr<ArchiveRun> run(new ArchiveRun(store, clock, std::move(health), options));
  TONUS_TRY(run->ingest_.recover());
  TONUS_TRY_ASSIGN(run->service_, ArchiveService::create(bus, run->ingest_, clock, notifier, &run->disk_));
  TONUS_TRY_ASSIGN(auto roster, runtime::Roster::create(bus, clock, notifier));
  run->roster_.emplace(std::move(roster));
  TONUS_TRY_ASSIGN(auto clocks,
                   runtime::ClockComparison::create(bus, clock, run->health_.instance(), notifier, {}));
  run->clocks_.emplace(std::move(clocks));
  return run;
}

Result<Clock::TimePoint> ArchiveRun::step() {
  const auto due = service_->step();
  roster_->update();
  const auto compare_due = clocks_->step(*roster_);
  const auto status = ingest_.status();
  const std::string why = service_->why_not_ready();
  health_.set_state(why.empty(), why.empty() ? "stores to " + store_.name() + disk_.need_text() : why);
  health_.set_load(service_->lag(), static_cast<std::uint32_t>(status.waiting_items), service_->dropped());
  const auto health_due = health_.publish_if_due();
  TONUS_TRY(health_.check_alone());
  return std::min({due, compare_due, health_due});
}

}  // namespace tonus::archive
