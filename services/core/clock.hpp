#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace tonus {

/// Time as the injected dependency that it is: services take a Clock, tests advance a ManualClock.
/// Monotonic time never steps; UTC is for people and file names only.
class Clock {
 public:
  using Duration = std::chrono::nanoseconds;
  using TimePoint = std::chrono::steady_clock::time_point;

  virtual ~Clock() = default;
  [[nodiscard]] virtual TimePoint now() const = 0;         ///< Monotonic.
  [[nodiscard]] virtual std::uint64_t utc_ns() const = 0;  ///< Since 1970-01-01, leap seconds not counted.
};

/// The host's clocks. Stateless; safe from any thread.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] TimePoint now() const override { return std::chrono::steady_clock::now(); }
  [[nodiscard]] std::uint64_t utc_ns() const override {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch()).count());
  }
};

/// A clock that stands still until it is told to go on. Not for use by several threads.
class ManualClock final : public Clock {
 public:
  [[nodiscard]] TimePoint now() const override { return TimePoint(elapsed_); }
  [[nodiscard]] std::uint64_t utc_ns() const override { return static_cast<std::uint64_t>(elapsed_.count()); }
  void advance(Duration duration) { elapsed_ += duration; }

 private:
  Duration elapsed_{};
};

/// ISO 8601 with seconds, e.g. "2026-03-01T12:00:00Z".
[[nodiscard]] std::string iso8601(std::uint64_t utc_ns);

}  // namespace tonus
