#include "services/bus/notifier.hpp"

namespace tonus::bus {

void Notifier::notify() noexcept {
  // Signalled under the lock: the waiter may destroy the notifier as soon as it has the lock.
  const std::lock_guard lock(mutex_);
  notified_ = true;
  changed_.notify_all();
}

bool Notifier::wait_until(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  const bool notified = changed_.wait_until(lock, deadline, [this] { return notified_; });
  notified_ = false;
  return notified;
}

}  // namespace tonus::bus
