#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

#include "services/dashboard/gateway/latest_values.hpp"
#include "services/dashboard/gateway/operator_request.hpp"

namespace tonus::dashboard {

/// From the threads that read the bus to the one that serves clients. put() never waits. Bounded: live
/// messages that find it full are left out and counted; state takes its room, up to ten times as much, after
/// which it is left out too and counted apart (the network thread has then stood still for long).
class Inbox {
 public:
  explicit Inbox(std::function<void()> wake, std::size_t limit_bytes = std::size_t{8} << 20)
      : wake_(std::move(wake)), limit_bytes_(limit_bytes) {}

  void put(PassedMessage message, bool is_live);
  void put(OperatorReply reply);

  struct Contents {
    std::vector<PassedMessage> messages;
    std::vector<OperatorReply> replies;
  };
  /// Everything that has come, in its order.
  [[nodiscard]] Contents take();

  [[nodiscard]] std::uint64_t live_dropped() const;
  [[nodiscard]] std::uint64_t state_dropped() const;

 private:
  std::function<void()> wake_;  ///< Called with the first message after a take().
  std::size_t limit_bytes_;
  mutable std::mutex mutex_;
  Contents contents_;
  std::size_t bytes_ = 0;
  std::uint64_t live_dropped_ = 0;
  std::uint64_t state_dropped_ = 0;
};

}  // namespace tonus::dashboard
