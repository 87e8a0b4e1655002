#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "services/bus/bus.hpp"
#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"
#include "services/core/id.hpp"
#include "services/core/result.hpp"

#include <idl/rig.h>

namespace tonus::runtime {

/// An operator's end of the stop topic, on a bus of its own: what other readers and writers do cannot hold it
/// up. One thread.
class RigStopSender {
 public:
  /// `bus` is not shared with anything else.
  [[nodiscard]] static Result<RigStopSender> create(std::unique_ptr<bus::Bus> bus, const Clock& clock);

  /// Sends the stop again and again until the rig's loop shows it. Returns how long that took; kTimeout after
  /// `limit`: no rig of that id confirmed it.
  [[nodiscard]] Result<Clock::Duration> stop(const Id& rig, const Id& stop_id,
                                             const std::string& requested_by, Clock::Duration limit);

 private:
  RigStopSender(std::unique_ptr<bus::Bus> bus, bus::TypedWriter<v1::RigStop> writer,
                bus::TypedReader<v1::RigStop> stopped, std::shared_ptr<bus::Notifier> notifier,
                const Clock& clock)
      : bus_(std::move(bus)),
        writer_(std::move(writer)),
        stopped_(std::move(stopped)),
        notifier_(std::move(notifier)),
        clock_(&clock) {}

  std::unique_ptr<bus::Bus> bus_;
  bus::TypedWriter<v1::RigStop> writer_;
  bus::TypedReader<v1::RigStop> stopped_;
  std::shared_ptr<bus::Notifier> notifier_;
  const Clock* clock_;
};

}  // namespace tonus::runtime
