#pragma once

#include <memory>
#include <string>
#include <vector>

#include "idl/topics.hpp"
#include "services/archive/disk_watch.hpp"
#include "services/archive/ingest.hpp"
#include "services/bus/bus.hpp"
#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"

namespace tonus::archive {

/// The archive's shell: moves bytes from the bus to Ingest and its decisions back. One thread, which sleeps
/// on the notifier between calls of step().
class ArchiveService {
 public:
  /// Subscribes to every topic that is kept. The ingest has recovered already. `disk`, where it is given,
  /// must live longer than the service.
  [[nodiscard]] static Result<std::unique_ptr<ArchiveService>> create(bus::Bus& bus, Ingest& ingest,
                                                                      const Clock& clock,
                                                                      std::shared_ptr<bus::Notifier> notifier,
                                                                      DiskWatch* disk = nullptr);

  /// Takes what has arrived, stores what is due, sends what has to be sent. Returns when to call again even
  /// if nothing arrives.
  Clock::TimePoint step();

  /// Messages taken since the start.
  [[nodiscard]] std::uint64_t taken() const { return taken_; }

  /// What keeps it from doing its job now, a line for a person; empty where nothing does.
  [[nodiscard]] std::string why_not_ready() const;

  /// Age of the newest input when it was handled, s.
  [[nodiscard]] double lag() const { return lag_; }

  /// Messages that could not be understood, or were lost on the way.
  [[nodiscard]] std::uint64_t dropped() const;

 private:
  struct Source {
    bus::TopicSpec topic;
    std::unique_ptr<bus::Reader> reader;
  };

  ArchiveService(Ingest& ingest, const Clock& clock, DiskWatch* disk, std::vector<Source> sources,
                 bus::TypedWriter<v1::ArchiveReceipt> receipts, bus::TypedWriter<v1::ArchiveResend> resends);
  bool take_all();
  void send(const Decisions& decisions);

  Ingest& ingest_;
  const Clock& clock_;
  DiskWatch* disk_;  ///< None: no budget.
  std::vector<Source> sources_;
  bus::TypedWriter<v1::ArchiveReceipt> receipts_;
  bus::TypedWriter<v1::ArchiveResend> resends_;
  std::vector<v1::ArchiveReceipt> unsent_;  ///< Receipts that the bus did not take yet.
  std::vector<bus::Sample> samples_;
  double lag_ = 0.0;
  std::uint64_t taken_ = 0;
  std::uint64_t malformed_ = 0;
};

}  // namespace tonus::archive
