#pragma once

namespace tonus::config {

/// A value that is drawn anew each time, uniformly; both ends equal: it is fixed.
struct Span {
  double low = 0.0;
  double high = 0.0;
  [[nodiscard]] double middle() const { return 0.5 * (low + high); }
};

}  // namespace tonus::config
