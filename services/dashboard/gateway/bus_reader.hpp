#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "services/bus/bus.hpp"
#include "services/core/clock.hpp"
#include "services/dashboard/gateway/inbox.hpp"
#include "services/dashboard/gateway/topic_table.hpp"

namespace tonus::dashboard {

/// Reads every topic from the bus and puts the bytes into the inbox, unread. Live topics are read only while
/// somebody wants them. For one thread, which never waits here; want() may be called from any.
class BusReader {
 public:
  [[nodiscard]] static Result<std::unique_ptr<BusReader>> create(bus::Bus& bus,
                                                                 const std::vector<OfferedTopic>& topics,
                                                                 Inbox& inbox, const Clock& clock,
                                                                 std::shared_ptr<bus::Notifier> notifier);

  /// Passes on what has arrived; returns when to call again even if nothing arrives. An error is that of a
  /// reader that could not be made.
  [[nodiscard]] Result<Clock::TimePoint> step();

  /// Whether anybody looks at a live topic now.
  void want(std::uint32_t channel, bool is_wanted);

  /// Age of the newest message when it was passed on, s.
  [[nodiscard]] double lag() const { return lag_; }
  [[nodiscard]] std::uint64_t malformed() const;

 private:
  struct Source {
    OfferedTopic topic;
    std::unique_ptr<bus::Reader> reader;
    std::atomic<bool> is_wanted{true};  // relaxed: a step later is early enough
    Clock::TimePoint unwanted_since{};
  };

  BusReader(bus::Bus& bus, Inbox& inbox, const Clock& clock, std::shared_ptr<bus::Notifier> notifier)
      : bus_(bus), inbox_(inbox), clock_(clock), notifier_(std::move(notifier)) {}
  [[nodiscard]] Result<void> open(Source& source);
  void close_if_unwanted(Source& source);
  void pass_on(Source& source);

  bus::Bus& bus_;
  Inbox& inbox_;
  const Clock& clock_;
  std::shared_ptr<bus::Notifier> notifier_;
  std::vector<std::unique_ptr<Source>> sources_;
  std::vector<bus::Sample> samples_;
  double lag_ = 0.0;
};

}  // namespace tonus::dashboard
