#include "services/dashboard/gateway/inbox.hpp"

#include <utility>

namespace tonus::dashboard {
namespace {

constexpr std::size_t kStateFactor = 10;

}  // namespace

void Inbox::put(PassedMessage message, bool is_live) {
  bool is_first = false;
  {
    const std::lock_guard lock(mutex_);
    if (bytes_ > (is_live ? limit_bytes_ : kStateFactor * limit_bytes_)) {
      ++(is_live ? live_dropped_ : state_dropped_);
      return;
    }
    is_first = contents_.messages.empty() && contents_.replies.empty();
    bytes_ += message.payload->size();
    contents_.messages.push_back(std::move(message));
  }
  if (is_first) wake_();
}

void Inbox::put(OperatorReply reply) {
  bool is_first = false;
  {
    const std::lock_guard lock(mutex_);
    is_first = contents_.messages.empty() && contents_.replies.empty();
    contents_.replies.push_back(std::move(reply));
  }
  if (is_first) wake_();
}

Inbox::Contents Inbox::take() {
  const std::lock_guard lock(mutex_);
  bytes_ = 0;
  return std::exchange(contents_, {});
}

std::uint64_t Inbox::live_dropped() const {
  const std::lock_guard lock(mutex_);
  return live_dropped_;
}

std::uint64_t Inbox::state_dropped() const {
  const std::lock_guard lock(mutex_);
  return state_dropped_;
}

}  // namespace tonus::dashboard
