#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace tonus::bus {

/// Wakes one service thread. A notify() before the wait is kept, so no wake-up is lost; several before one
/// wait count as one. Whoever is woken looks at all its sources.
class Notifier {
 public:
  Notifier() = default;
  Notifier(const Notifier&) = delete;
  Notifier& operator=(const Notifier&) = delete;

  /// From any thread, also from a vendor's listener; does not wait.
  void notify() noexcept;

  /// Waits for a notification; true and clears it if there was one before `deadline`, else false.
  [[nodiscard]] bool wait_until(std::chrono::steady_clock::time_point deadline);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool notified_ = false;
};

}  // namespace tonus::bus
