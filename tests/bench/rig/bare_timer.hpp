#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "rig_agent/control/pacer.hpp"
#include "rig_agent/control/realtime_setup.hpp"

namespace tonus {

/// A thread that does nothing but wait for its next period, with the same realtime means as the rig's loop:
/// what of a loop's lateness is the machine's.
class BareTimer {
 public:
  BareTimer(std::int64_t period_ns, const control::RealtimeRequest& request) : pacer_(clock_, period_ns) {
    thread_ = std::thread([this, request] {
      statement_ = control::set_up_realtime(request).statement;
      is_set_up_.store(true, std::memory_order_release);
      is_set_up_.notify_all();
      pacer_.start();
      while (!is_stopping_.load(std::memory_order_acquire)) pacer_.wait();
    });
    is_set_up_.wait(false, std::memory_order_acquire);
  }
  ~BareTimer() { stop(); }
  void stop() {
    is_stopping_.store(true, std::memory_order_release);
    if (thread_.joinable()) thread_.join();
  }
  [[nodiscard]] const control::Pacer& pacer() const { return pacer_; }
  /// What the operating system permitted.
  [[nodiscard]] const std::string& statement() const { return statement_; }

 private:
  control::MonotonicClock clock_;
  control::Pacer pacer_;
  std::string statement_;  // Before is_set_up_ (release), read after it (acquire).
  std::atomic<bool> is_set_up_{false};
  std::atomic<bool> is_stopping_{false};
  std::thread thread_;
};

}  // namespace tonus
