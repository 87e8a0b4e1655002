#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tonus::bus {

/// Reads numbers from bytes and never past their end: after the first read that would, has_failed() is true
/// and every number is 0. Copies are cheap and independent.
class ByteCursor {
 public:
  ByteCursor(std::span<const std::byte> bytes, bool is_little_endian)
      : bytes_(bytes), is_little_endian_(is_little_endian) {}

  [[nodiscard]] bool has_failed() const { return has_failed_; }
  [[nodiscard]] std::size_t left() const { return has_failed_ ? 0 : bytes_.size() - at_; }
  [[nodiscard]] std::size_t position() const { return at_; }

  std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }

  /// A sequence number: high word first, whatever the byte order of each.
  std::int64_t sequence_number() {
    const std::uint64_t high = u32();
    const std::uint64_t low = u32();
    return static_cast<std::int64_t>(high << 32U | low);
  }

  /// The next `count` bytes; empty where there are fewer.
  std::span<const std::byte> take(std::size_t count) {
    if (count > left()) {
      has_failed_ = true;
      return {};
    }
    const auto taken = bytes_.subspan(at_, count);
    at_ += count;
    return taken;
  }

  void skip(std::size_t count) { (void)take(count); }

  /// On to the next multiple of 4, or to the end.
  void align() {
    const std::size_t padding = (4 - at_ % 4) % 4;
    skip(padding < left() ? padding : left());
  }

 private:
  std::uint64_t number(std::size_t size) {
    const auto bytes = take(size);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const std::size_t place = is_little_endian_ ? i : bytes.size() - 1 - i;
      value |= static_cast<std::uint64_t>(bytes[i]) << (8 * place);
    }
    return value;
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool is_little_endian_;
  bool has_failed_ = false;
};

}  // namespace tonus::bus
