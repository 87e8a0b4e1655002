#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace tonus::control {

/// The clock that a pacer goes by. ns since any fixed instant.
class PacerClock {
 public:
  virtual ~PacerClock() = default;
  PacerClock() = default;
  PacerClock(const PacerClock&) = delete;
  PacerClock& operator=(const PacerClock&) = delete;

  [[nodiscard]] virtual std::int64_t now_ns() noexcept = 0;
  /// Returns at or after `wake_ns`.
  virtual void sleep_until_ns(std::int64_t wake_ns) noexcept = 0;
};

/// CLOCK_MONOTONIC, with clock_nanosleep to an absolute time.
class MonotonicClock final : public PacerClock {
 public:
  [[nodiscard]] std::int64_t now_ns() noexcept override;
  void sleep_until_ns(std::int64_t wake_ns) noexcept override;
};

/// How late the cycles of a loop began, in classes that double: class 0 holds lateness under 1 us, class i
/// from 2^(i-1) to 2^i us, the last one everything above. One writer; any thread may read.
class JitterHistogram {
 public:
  static constexpr std::size_t kClasses = 18;  // The last begins at 65.5 ms.

  /// REALTIME.
  void add(std::int64_t lateness_ns) noexcept;
  [[nodiscard]] std::uint64_t count(std::size_t i) const noexcept {
    return counts_[i].load(std::memory_order_relaxed);  // Counts order nothing.
  }
  /// Upper edge of class i in us; the last class has none and gives the largest int64.
  [[nodiscard]] static std::int64_t upper_edge_us(std::size_t i) noexcept;
  [[nodiscard]] std::int64_t worst_ns() const noexcept { return worst_ns_.load(std::memory_order_relaxed); }

 private:
  std::array<std::atomic<std::uint64_t>, kClasses> counts_{};
  std::atomic<std::int64_t> worst_ns_{0};
};

/// One cycle's beginning, as the pacer saw it.
struct CycleStart {
  std::int64_t now_ns = 0;       ///< When the cycle begins.
  std::int64_t lateness_ns = 0;  ///< After its due time; 0 or more.
  unsigned missed_periods = 0;   ///< Whole periods that passed without a cycle before this one.
};

/// Starts cycles at due times on an absolute grid: due_k = start + k period. A late cycle does not shift the
/// ones after it. When whole periods were missed they are counted and left out; the grid stays.
///
/// Threads: start() and wait() belong to the loop's thread; the counters may be read from any.
class Pacer {
 public:
  Pacer(PacerClock& clock, std::int64_t period_ns) : clock_(clock), period_ns_(period_ns) {}

  /// The first cycle is due one period from now.
  void start() noexcept { due_ns_ = clock_.now_ns() + period_ns_; }
  /// REALTIME. Sleeps until the next cycle is due.
  CycleStart wait() noexcept;

  [[nodiscard]] const JitterHistogram& jitter() const noexcept { return jitter_; }
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_.load(std::memory_order_relaxed); }
  /// Cycles that began after periods had been missed.
  [[nodiscard]] std::uint64_t overruns() const noexcept { return overruns_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t missed_periods() const noexcept {
    return missed_.load(std::memory_order_relaxed);
  }

 private:
  PacerClock& clock_;
  const std::int64_t period_ns_;
  std::int64_t due_ns_ = 0;
  JitterHistogram jitter_;
  std::atomic<std::uint64_t> cycles_{0};
  std::atomic<std::uint64_t> overruns_{0};
  std::atomic<std::uint64_t> missed_{0};
};

}  // namespace tonus::control
