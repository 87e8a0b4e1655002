#pragma once

#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
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
  LoopThread(control::RigLoop& loop, bool is_paced, const control::RealtimeRequest& request);
  ~LoopThread() { stop(); }
  LoopThread(const LoopThread&) = delete;
  LoopThread& operator=(const LoopThread&) = delete;

  /// Ends the loop. False where it does not come back from its driver within `limit`: the thread is left, and
  /// the program has to end without waiting for it.
  bool stop(std::chrono::milliseconds limit = std::chrono::seconds(2));
  [[nodiscard]] const std::string& statement() const { return grant_.statement; }
  /// What was refused of the realtime means that were asked for: the statement; empty where nothing was.
  [[nodiscard]] std::string refusal() const { return grant_.is_complete ? "" : grant_.statement; }
  /// Null where the loop is not paced.
  [[nodiscard]] const control::Pacer* pacer() const { return thread_.joinable() ? &pacer_ : nullptr; }

 private:
  control::MonotonicClock clock_;
  control::Pacer pacer_;
  control::RealtimeGrant grant_;
  // Written by stop() (release), read by the loop (acquire).
  std::atomic<bool> is_stopping_{false};
  std::future<void> ended_;
  std::thread thread_;
};

}  // namespace tonus::rig
