#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "rig_agent/control/fault.hpp"
#include "rig_agent/control/sample_record.hpp"

namespace tonus::control {

/// Everything that one cycle of the loop measured, wanted and did. Plain data; SI, in the robot's base frame
/// R.
struct CycleRecord {
  std::uint64_t cycle = 0;
  std::int64_t now_ns = 0;  ///< The loop's clock at the start of the cycle.
  RawSample raw;
  std::array<double, 2> position{};   ///< m, handle, as measured.
  std::array<double, 2> velocity{};   ///< m/s, handle, by the observer.
  std::array<double, 2> force{};      ///< N, on the arm.
  std::array<double, 2> reference{};  ///< m, where the servo leads the handle.
  std::array<double, 2> torque{};     ///< N m, as written.
  FaultBits faults = 0;               ///< Latched.
  std::uint32_t missed_periods = 0;   ///< Before this cycle.
  Phase phase = Phase::kIdle;
};

/// Keeps the last records of the loop, and holds them still from a fault on until they have been read and are
/// released. Frozen records are numbered, 1, 2, ...
///
/// Threads: put(), freeze() and release_if_read() belong to the loop; the rest may be called from one other
/// thread, which reads records only while is_frozen() and before set_read().
class FlightRecorder {
 public:
  explicit FlightRecorder(std::size_t capacity)
      : capacity_(capacity), records_(std::make_unique<CycleRecord[]>(capacity)) {}

  /// REALTIME. Overwrites the oldest; does nothing while frozen.
  void put(const CycleRecord& record) noexcept {
    if (is_frozen_.load(std::memory_order_relaxed)) return;
    records_[written_ % capacity_] = record;
    ++written_;
  }

  /// REALTIME. Does nothing while frozen.
  void freeze() noexcept {
    if (is_frozen_.load(std::memory_order_relaxed)) return;
    number_.fetch_add(1, std::memory_order_relaxed);
    // Release pairs with the acquire in is_frozen(): who sees the recorder frozen sees every record.
    is_frozen_.store(true, std::memory_order_release);
  }
  /// REALTIME. Recording goes on if the frozen record has been read; else it stays as it is.
  void release_if_read() noexcept {
    // Acquire pairs with the release in set_read(): nothing is overwritten that is still being read.
    if (!is_frozen_.load(std::memory_order_relaxed) ||
        read_.load(std::memory_order_acquire) != number_.load(std::memory_order_relaxed)) {
      return;
    }
    is_frozen_.store(false, std::memory_order_release);
  }

  [[nodiscard]] bool is_frozen() const noexcept { return is_frozen_.load(std::memory_order_acquire); }
  /// Number of the record that was frozen last; 0: none yet.
  [[nodiscard]] std::uint32_t number() const noexcept { return number_.load(std::memory_order_relaxed); }
  /// Records held; 0 unless frozen.
  [[nodiscard]] std::size_t size() const noexcept {
    if (!is_frozen()) return 0;
    return written_ < capacity_ ? static_cast<std::size_t>(written_) : capacity_;
  }
  /// Record i < size(), the oldest first; the last is the cycle that found the fault.
  [[nodiscard]] const CycleRecord& at(std::size_t i) const noexcept {
    const std::uint64_t first = written_ < capacity_ ? 0 : written_ - capacity_;
    return records_[(first + i) % capacity_];
  }
  /// The record of this number is not needed any more.
  void set_read(std::uint32_t number) noexcept { read_.store(number, std::memory_order_release); }

 private:
  const std::size_t capacity_;
  const std::unique_ptr<CycleRecord[]> records_;
  std::uint64_t written_ = 0;
  std::atomic<bool> is_frozen_{false};
  std::atomic<std::uint32_t> number_{0};
  std::atomic<std::uint32_t> read_{0};
};

}  // namespace tonus::control
