#pragma once

#include <cstdint>
#include <memory>
#include <thread>

#include "rig_agent/agent/lease.hpp"
#include "rig_agent/agent/stop_requests.hpp"
#include "rig_agent/control/rig_loop.hpp"
#include "services/bus/bus.hpp"
#include "services/core/clock.hpp"
#include "services/core/result.hpp"

namespace tonus::rig {

/// The rig's end of the stop and lease topics: a bus and a thread of their own, so that no other traffic and
/// no deaf client can hold them up. A stop sets the loop's flag at once, is noted for the agent, and is
/// confirmed on kRigStopped when the loop shows it. Where there is to be but one thread, step() does the
/// same.
class SafetyChannel {
 public:
  enum class Works : std::uint8_t { kInOwnThread, kByStep };

  /// `bus` is not shared with anything else. `wake` is the agent's notifier.
  [[nodiscard]] static Result<std::unique_ptr<SafetyChannel>> create(
      std::unique_ptr<bus::Bus> bus, const Id& rig, control::RigLoop& loop, Lease& lease, StopRequests& stops,
      const Clock& clock, std::shared_ptr<bus::Notifier> wake, Works works = Works::kInOwnThread);
  ~SafetyChannel();
  SafetyChannel(const SafetyChannel&) = delete;
  SafetyChannel& operator=(const SafetyChannel&) = delete;

  /// Of kByStep: handles all there is; returns when to call again at the latest.
  Clock::TimePoint step();
  /// Told when there is something for step().
  [[nodiscard]] const std::shared_ptr<bus::Notifier>& notifier() const;

 private:
  class Work;
  SafetyChannel(std::unique_ptr<Work> work, Works works);

  std::unique_ptr<Work> work_;
  std::thread thread_;
};

}  // namespace tonus::rig
