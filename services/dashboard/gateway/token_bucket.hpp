#pragma once

#include <algorithm>

#include "services/core/clock.hpp"

namespace tonus::dashboard {

/// A token bucket: `per_second` on average, and up to `burst` at once.
class TokenBucket {
 public:
  TokenBucket(double per_second, double burst) : per_second_(per_second), burst_(burst), left_(burst) {}

  [[nodiscard]] bool spend(Clock::TimePoint now) {
    if (at_ != Clock::TimePoint{}) {
      const double elapsed = std::chrono::duration<double>(now - at_).count();
      left_ = std::min(burst_, left_ + elapsed * per_second_);
    }
    at_ = now;
    if (left_ < 1.0) return false;
    left_ -= 1.0;
    return true;
  }

 private:
  double per_second_;
  double burst_;
  double left_;
  Clock::TimePoint at_{};
};

}  // namespace tonus::dashboard
