#pragma once

#include <mutex>
#include <string>
#include <utility>

namespace tonus::rig {

/// Who has asked for a stop since the agent last looked. The loop has been stopped already; this is for the
/// record. From any thread.
class StopRequests {
 public:
  void add(const std::string& requested_by) {
    const std::lock_guard lock(mutex_);
    if (requested_by_.size() < kMostText) requested_by_ += (requested_by_.empty() ? "" : ", ") + requested_by;
  }
  /// Names, and forgets them; empty: nobody.
  [[nodiscard]] std::string take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(requested_by_, {});
  }

 private:
  static constexpr std::size_t kMostText = 200;
  std::mutex mutex_;
  std::string requested_by_;
};

}  // namespace tonus::rig
