#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "services/core/clock.hpp"
#include "services/dashboard/gateway/frames.hpp"
#include "services/dashboard/gateway/token_bucket.hpp"

namespace tonus::dashboard {

/// What waits to be sent to one client. State and results (kept, or once) wait in a queue from which nothing
/// is taken but by sending: where it is full, the client is too slow to be told the truth, and has to go.
/// Live messages are thinned: at most so many a second of each subscription, and at most so many waiting, of
/// which the oldest gives way; all that are left out are counted. State goes first.
class Outbox {
 public:
  struct Limits {
    std::size_t state_messages = 32768;
    std::size_t state_bytes = std::size_t{32} << 20;
    std::size_t live_messages = 128;
    std::size_t live_bytes = std::size_t{2} << 20;
    double live_rate =
        250.0;  ///< Messages/s of one subscription; bursts up to a quarter of a second's worth.
  };

  explicit Outbox(const Limits& limits) : limits_(limits) {}

  /// False, and nothing is queued, when the queue is full.
  [[nodiscard]] bool push_state(Outgoing message);
  void push_live(std::uint32_t subscription, Outgoing message, Clock::TimePoint now);

  [[nodiscard]] std::optional<Outgoing> pop();

  /// Forgets everything that waits.
  void clear();
  /// The subscription has ended.
  void forget(std::uint32_t subscription) { buckets_.erase(subscription); }

  [[nodiscard]] bool is_empty() const { return state_.empty() && live_.empty(); }
  [[nodiscard]] std::size_t waiting_messages() const { return state_.size() + live_.size(); }
  [[nodiscard]] std::size_t waiting_bytes() const { return state_bytes_ + live_bytes_; }
  [[nodiscard]] std::uint64_t thinned() const { return thinned_; }
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

 private:
  [[nodiscard]] Outgoing take_live();

  Limits limits_;
  std::deque<Outgoing> state_;
  std::deque<Outgoing> live_;
  std::map<std::uint32_t, TokenBucket> buckets_;  ///< Of each live subscription.
  std::size_t state_bytes_ = 0;
  std::size_t live_bytes_ = 0;
  std::uint64_t thinned_ = 0;
  std::uint64_t sent_ = 0;
};

}  // namespace tonus::dashboard
