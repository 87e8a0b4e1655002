#pragma once

#include <algorithm>
#include <limits>
#include <spdlog/fmt/fmt.h>
#include <string>

namespace tonus::report {

/// Counts how often something was so.
struct Share {
  int hits = 0;
  int all = 0;
  void add(bool is_hit) {
    hits += is_hit ? 1 : 0;
    ++all;
  }
  [[nodiscard]] std::string text() const {
    return all == 0 ? "–" : fmt::format("{:.0f} % ({} of {})", 100.0 * hits / all, hits, all);
  }
};

/// Smallest, mean and largest of some values.
struct Spread {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  double sum = 0.0;
  int count = 0;
  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
    sum += value;
    ++count;
  }
  [[nodiscard]] double mean() const { return count == 0 ? 0.0 : sum / count; }
  [[nodiscard]] std::string text(const char* unit, int digits) const {
    return count == 0 ? "–"
                      : fmt::format("{:.{}f} to {:.{}f}, mean {:.{}f}{}", least, digits, most, digits, mean(),
                                    digits, unit);
  }
};

}  // namespace tonus::report
