#include "services/dashboard/gateway/outbox.hpp"

#include <algorithm>
#include <utility>

namespace tonus::dashboard {
namespace {

constexpr double kBurst = 0.25;  // s

}  // namespace

bool Outbox::push_state(Outgoing message) {
  const std::size_t bytes = message.bytes();
  if (state_.size() >= limits_.state_messages || state_bytes_ + bytes > limits_.state_bytes) return false;
  state_bytes_ += bytes;
  state_.push_back(std::move(message));
  return true;
}

void Outbox::push_live(std::uint32_t subscription, Outgoing message, Clock::TimePoint now) {
  const auto bucket =
      buckets_.try_emplace(subscription, limits_.live_rate, std::max(1.0, limits_.live_rate * kBurst)).first;
  if (!bucket->second.spend(now)) {
    ++thinned_;
    return;
  }
  live_bytes_ += message.bytes();
  live_.push_back(std::move(message));
  while (live_.size() > 1 && (live_.size() > limits_.live_messages || live_bytes_ > limits_.live_bytes)) {
    (void)take_live();
    ++thinned_;
  }
}

Outgoing Outbox::take_live() {
  Outgoing message = std::move(live_.front());
  live_.pop_front();
  live_bytes_ -= message.bytes();
  return message;
}

std::optional<Outgoing> Outbox::pop() {
  if (is_empty()) return std::nullopt;
  ++sent_;
  if (state_.empty()) return take_live();
  Outgoing message = std::move(state_.front());
  state_.pop_front();
  state_bytes_ -= message.bytes();
  return message;
}

void Outbox::clear() {
  state_.clear();
  live_.clear();
  buckets_.clear();
  state_bytes_ = 0;
  live_bytes_ = 0;
}

}  // namespace tonus::dashboard
