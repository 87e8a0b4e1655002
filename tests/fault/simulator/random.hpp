#pragma once

#include <cstdint>
#include <random>

namespace tonus::simulator {

/// All that is drawn in a simulation, from one seed, the same everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : source_(seed) {}
  [[nodiscard]] std::uint64_t next() { return source_(); }
  [[nodiscard]] unsigned below(unsigned n) { return static_cast<unsigned>(source_() % n); }
  [[nodiscard]] double between(double low, double high) {
    return low + (high - low) * static_cast<double>(source_() >> 11) * 0x1.0p-53;
  }
  [[nodiscard]] bool chance(double probability) { return between(0.0, 1.0) < probability; }

 private:
  std::mt19937_64 source_;
};

}  // namespace tonus::simulator
