#pragma once

#include <memory>
#include <optional>

#include "services/archive/archive_service.hpp"
#include "services/archive/disk_watch.hpp"
#include "services/archive/ingest.hpp"
#include "services/runtime/clock_comparison.hpp"
#include "services/runtime/health.hpp"

namespace tonus::archive {

/// One run of the archive between a bus and an open store: takes, stores, compares clocks, and says how it
/// is. One thread calls step().
class ArchiveRun {
 public:
  struct Options {
    Ingest::Options ingest;
    DiskBudget::Options disk;
  };

  /// Recovers what the store holds. `bus`, `store` and `clock` live longer.
  [[nodiscard]] static Result<std::unique_ptr<ArchiveRun>> create(bus::Bus& bus, store::Store& store,
                                                                  const Clock& clock,
                                                                  std::shared_ptr<bus::Notifier> notifier,
                                                                  runtime::HealthReporter health,
                                                                  const Options& options);

  /// Handles all there is; returns when to call again at the latest. The error: this process is the second of
  /// two archives.
  [[nodiscard]] Result<Clock::TimePoint> step();

  /// Takes and stores alone, for what is still on its way at the end.
  Clock::TimePoint take_the_rest() { return service_->step(); }
  /// Messages taken since the start.
  [[nodiscard]] std::uint64_t taken() const { return service_->taken(); }
  /// Stores what waits, for an orderly end.
  [[nodiscard]] Result<void> finish() { return ingest_.finish(); }

 private:
  ArchiveRun(store::Store& store, const Clock& clock, runtime::HealthReporter health, const Options& options);

  store::Store& store_;
  runtime::HealthReporter health_;
  Ingest ingest_;
  DiskWatch disk_;
  std::unique_ptr<ArchiveService> service_;
  std::optional<runtime::Roster> roster_;
  std::optional<runtime::ClockComparison> clocks_;
};

}  // namespace tonus::archive
