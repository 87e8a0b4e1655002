#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace tonus {

/// Turns SIGINT and SIGTERM into an orderly end. Construct it first in main(), before any thread: it blocks
/// both signals in this thread and all that it starts later, and one thread of its own waits for them.
/// `on_stop` is called from that thread, each time; it may only wake somebody (a Notifier).
class StopSignal {
 public:
  explicit StopSignal(std::function<void()> on_stop = {});
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  [[nodiscard]] bool is_requested() const { return requests() > 0; }
  /// How often it was asked, for a program that gives the second time another meaning.
  [[nodiscard]] int requests() const { return requests_.load(std::memory_order_acquire); }

 private:
  std::function<void()> on_stop_;
  // Written by the waiting thread (release), read by anybody (acquire).
  std::atomic<int> requests_{0};
  std::atomic<bool> is_ending_{false};
  std::thread waiter_;
};

/// In a child between fork and exec, or in a program that does not use StopSignal: undoes the blocking.
void unblock_stop_signals();

}  // namespace tonus
