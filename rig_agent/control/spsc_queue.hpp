#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

namespace tonus::control {

/// Bounded queue from exactly one producing thread to exactly one consuming thread. Lock-free and wait-free;
/// memory is reserved by the constructor alone. A push into a full queue is refused and counted. With each
/// item may go a row of floats, of a length that is fixed when the queue is made.
///
/// Two counters that only grow: tail_ is written by the producer, head_ by the consumer; an item's slot is
/// its number modulo the capacity. Each side reads its own counter relaxed, because nobody else writes it.
template <typename T>
class SpscQueue {
 public:
  /// Holds at least `capacity` items (rounded up to a power of two).
  explicit SpscQueue(std::size_t capacity, std::size_t row = 0)
      : mask_(std::bit_ceil(capacity < 2 ? std::size_t{2} : capacity) - 1),
        row_(row),
        slots_(std::make_unique<T[]>(mask_ + 1)),
        rows_(std::make_unique<float[]>(row * (mask_ + 1))) {}

  /// Producer. REALTIME. False when full: the item is dropped and counted. `row` is as long as row().
  bool try_push(const T& item, std::span<const float> row = {}) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    // The last known head spares the producer the consumer's cache line until the queue looks full.
    if (tail - known_head_ > mask_) {
      // Acquire pairs with the release in try_pop: the consumer has finished reading the slot that is reused.
      known_head_ = head_.load(std::memory_order_acquire);
      if (tail - known_head_ > mask_) {
        dropped_.fetch_add(1, std::memory_order_relaxed);  // A count alone; orders nothing.
        return false;
      }
    }
    slots_[tail & mask_] = item;
    std::copy(row.begin(), row.end(), rows_.get() + (tail & mask_) * row_);
    // Release pairs with the acquire in try_pop: the item is written before it is announced.
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer. REALTIME. False when empty. `row` is as long as row(), or empty: then it is left out.
  bool try_pop(T& item, std::span<float> row = {}) noexcept {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head == known_tail_) {
      // Acquire pairs with the release in try_push: the item is complete before it is read.
      known_tail_ = tail_.load(std::memory_order_acquire);
      if (head == known_tail_) return false;
    }
    item = slots_[head & mask_];
    std::copy_n(rows_.get() + (head & mask_) * row_, row.size(), row.begin());
    // Release pairs with the acquire in try_push: the slot is read before it is given back.
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Any thread; exact only in the producer (may be too large) and the consumer (may be too small).
  [[nodiscard]] std::size_t size() const noexcept {
    const std::uint64_t head = head_.load(std::memory_order_acquire);
    return static_cast<std::size_t>(tail_.load(std::memory_order_acquire) - head);
  }
  [[nodiscard]] std::size_t capacity() const noexcept { return mask_ + 1; }
  /// Floats with each item.
  [[nodiscard]] std::size_t row() const noexcept { return row_; }
  /// Any thread. Items refused since construction.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kCacheLine = 64;

  const std::size_t mask_;
  const std::size_t row_;
  const std::unique_ptr<T[]> slots_;
  const std::unique_ptr<float[]> rows_;
  alignas(kCacheLine) std::atomic<std::uint64_t> tail_{0};
  std::uint64_t known_head_ = 0;  // Producer's.
  std::atomic<std::uint64_t> dropped_{0};
  alignas(kCacheLine) std::atomic<std::uint64_t> head_{0};
  std::uint64_t known_tail_ = 0;  // Consumer's.
};

}  // namespace tonus::control
