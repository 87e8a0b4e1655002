#pragma once

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace tonus::protocol {

/// Random numbers that are the same on every machine: std::mt19937_64, whose sequence the C++ standard fixes,
/// seeded with splitmix64(seed + golden ratio * stream), and mapped here, because the standard leaves the
/// mapping of its distributions open. A stream is one purpose (a set's order, a repeated trial), so that what
/// one purpose draws does not depend on how often another has drawn.
class Draws {
 public:
  Draws(std::uint64_t seed, std::uint64_t stream) : engine_(mix(seed + 0x9e3779b97f4a7c15ULL * stream)) {}

  /// Uniform in [low, high): the upper 53 bits of one draw, times 2^-53. `low` where both are equal.
  [[nodiscard]] double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1.0p-53);
  }

  /// Uniform in 0 .. count - 1, count > 0, without bias: draws beyond the last whole multiple of count are
  /// thrown away.
  [[nodiscard]] std::uint64_t below(std::uint64_t count) {
    const std::uint64_t excess = (0 - count) % count;  // 2^64 mod count
    std::uint64_t draw = engine_();
    while (draw > UINT64_MAX - excess) draw = engine_();
    return draw % count;
  }

  /// Fisher and Yates: every order is equally likely.
  template <typename T>
  void shuffle(std::vector<T>& items) {
    for (std::size_t left = items.size(); left > 1; --left) std::swap(items[left - 1], items[below(left)]);
  }

 private:
  [[nodiscard]] static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  std::mt19937_64 engine_;
};

}  // namespace tonus::protocol
