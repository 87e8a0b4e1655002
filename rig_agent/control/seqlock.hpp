#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace tonus::control {

/// One writer's latest value for any number of readers: the writer never waits, a reader tries again when the
/// value changed while it read. The words are atomics, so that the overlap is no data race; they are stored
/// with release and loaded with acquire in place of fences, which thread sanitizers do not follow.
template <typename T>
class Seqlock {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Seqlock() { store(T{}); }

  /// The one writer. REALTIME.
  void store(const T& value) noexcept {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    const std::uint64_t version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);  // Odd: being written.
    // Release pairs with the acquire of the words in load(): a reader that saw one new word sees, in its
    // second look, the odd version or a later one.
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_release);
    // Release pairs with the first acquire in load(): an even version announces complete words.
    version_.store(version + 2, std::memory_order_release);
  }

  /// Any thread.
  [[nodiscard]] T load() const noexcept {
    std::array<std::uint64_t, kWords> words{};
    for (;;) {
      const std::uint64_t before = version_.load(std::memory_order_acquire);
      for (std::size_t i = 0; i < kWords; ++i) words[i] = words_[i].load(std::memory_order_acquire);
      if (before % 2 == 0 && before == version_.load(std::memory_order_relaxed)) break;
    }
    T value;
    std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
    return value;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;
  std::atomic<std::uint64_t> version_{0};
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace tonus::control
