#pragma once

#include <atomic>
#include <cmath>
#include <string>
#include <thread>

#include "rig_agent/control/pacer.hpp"
#include "rig_agent/control/realtime_setup.hpp"
#include "rig_agent/control/rig_loop.hpp"

namespace tonus::rig {

/// The realtime loop in a thread of its own, paced by the monotonic clock; no thread at all where the loop is
/// not paced. The statement says what the operating system permitted.
class LoopThread {
 public:
  LoopThread(control::RigLoop& loop, bool is_paced);
  ~LoopThread() { stop(); }
  LoopThread(const LoopThread&) = delete;
  LoopThread& operator=(const LoopThread&) = delete;

  void stop();
  [[nodiscard]] const std::string& statement() const { return statement_; }
  [[nodiscard]] const control::Pacer& pacer() const { return pacer_; }

 private:
  control::MonotonicClock clock_;
  control::Pacer pacer_;
  std::string statement_;
  // Written by stop() (release), read by the loop (acquire).
  std::atomic<bool> is_stopping_{false};
  std::thread thread_;
};

}  // namespace tonus::rig
