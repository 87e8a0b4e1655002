#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace tonus::fuzz {

using Bytes = std::vector<std::byte>;

/// Damages bytes as disks, networks and strangers do; the same seed does the same.
class Damage {
 public:
  explicit Damage(std::uint64_t seed) : generator_(seed) {}

  /// One to four of: bits flipped, a stretch overwritten with random bytes, zeros or ones, bytes cut out of
  /// the middle, cut off the end, put in, or copied from elsewhere; sometimes nothing but random bytes.
  void apply(Bytes& bytes);

  std::uint64_t draw(std::uint64_t low, std::uint64_t high) {
    return std::uniform_int_distribution<std::uint64_t>(low, high)(generator_);
  }

 private:
  void apply_one(Bytes& bytes);

  std::mt19937_64 generator_;
};

[[nodiscard]] Bytes read_bytes(const std::string& path);
void write_bytes(const std::string& path, const Bytes& bytes);

}  // namespace tonus::fuzz
