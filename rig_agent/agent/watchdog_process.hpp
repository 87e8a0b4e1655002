#pragma once

#include <memory>
#include <string>
#include <sys/types.h>

#include "rig_agent/control/pulse.hpp"
#include "services/core/clock.hpp"
#include "services/core/result.hpp"

namespace tonus::rig {

/// What tonus-rig-watchdog is to know: the driver as the agent's command line names it.
struct WatchdogOptions {
  double limit = 0.02;  ///< s without a cycle.
  int fifo_priority = 0;
  std::string driver;
  std::string driver_file;
  std::string driver_options;
};

/// The watchdog's process and the page of memory that it shares with the loop. The process outlives an agent
/// that is killed until the torque is off; it ends at once after one that says goodbye.
class WatchdogProcess {
 public:
  /// Starts the program beside this one. kUnavailable: it does not start.
  [[nodiscard]] static Result<std::unique_ptr<WatchdogProcess>> start(const WatchdogOptions& options,
                                                                      const Clock& clock);
  ~WatchdogProcess();
  WatchdogProcess(const WatchdogProcess&) = delete;
  WatchdogProcess& operator=(const WatchdogProcess&) = delete;

  [[nodiscard]] control::Pulse& pulse() { return *pulse_; }
  /// From then on, or no longer, a missing cycle drops the torque.
  void set_powered(bool is_powered) {
    pulse_->is_powered.store(is_powered ? 1 : 0, std::memory_order_relaxed);
  }
  /// What is wrong with the watchdog itself; empty: it looks.
  [[nodiscard]] std::string problem();

 private:
  WatchdogProcess(control::Pulse* pulse, pid_t process, const Clock& clock)
      : pulse_(pulse), process_(process), clock_(clock), looked_at_(clock.now()) {}

  control::Pulse* const pulse_;
  pid_t process_;
  const Clock& clock_;
  std::uint64_t looks_ = 0;
  Clock::TimePoint looked_at_;
};

}  // namespace tonus::rig
