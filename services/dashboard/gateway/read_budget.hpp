#pragma once

#include <algorithm>
#include <boost/beast/core/rate_policy.hpp>
#include <cstddef>
#include <functional>
#include <utility>

namespace tonus::dashboard {

/// How many bytes a connection may still receive before something whole has come of them: a request, a
/// message, a control frame. What arrives piece by piece, or in frames that hold nothing, is then bounded by
/// its bytes on the wire. A rate policy of Boost.Beast's streams; used by the stream's thread.
class ReadBudget {
 public:
  void renew(std::size_t bytes) { left_ = bytes; }

  /// Something small came whole between the pieces of the rest.
  void add(std::size_t bytes) { left_ += bytes; }

  /// `on_spent` is called once when the budget is used up, within a second; the stream then nearly stands
  /// still until it is renewed.
  void when_spent(std::function<void()> on_spent) { on_spent_ = std::move(on_spent); }

 private:
  friend class boost::beast::rate_policy_access;

  [[nodiscard]] std::size_t available_read_bytes() const { return left_; }
  [[nodiscard]] static std::size_t available_write_bytes() { return static_cast<std::size_t>(-1); }
  void transfer_read_bytes(std::size_t bytes) { left_ -= std::min(left_, bytes); }
  void transfer_write_bytes(std::size_t /*bytes*/) {}
  void on_timer() {
    if (left_ == 0 && on_spent_) std::exchange(on_spent_, nullptr)();
  }

  std::size_t left_ = std::size_t{64} * 1024;
  std::function<void()> on_spent_;
};

}  // namespace tonus::dashboard
