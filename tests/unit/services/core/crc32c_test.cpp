#include "services/core/crc32c.hpp"

#include <cstring>
#include <gtest/gtest.h>
#include <string_view>
#include <vector>

namespace tonus {
namespace {

std::uint32_t of(std::string_view text) { return crc32c(std::as_bytes(std::span(text.data(), text.size()))); }

TEST(Crc32c, GivesThePublishedCheckValues) {
  EXPECT_EQ(of("123456789"), 0xE3069283U);  // RFC 3720, appendix B.4, and the catalogue of parametrised CRCs
  const std::vector<std::byte> zeros(32);
  EXPECT_EQ(crc32c(zeros), 0x8A9136AAU);  // RFC 3720, appendix B.4
  EXPECT_EQ(crc32c(std::vector<std::byte>(32, std::byte{0xFF})), 0x62A8AB43U);
}

TEST(Crc32c, OfNothingIsZero) { EXPECT_EQ(of(""), 0U); }

/// The definition: the polynomial 0x1EDC6F41 with its bits reversed, bit by bit.
std::uint32_t bit_by_bit(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::byte octet : bytes) {
    crc ^= std::to_integer<std::uint32_t>(octet);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0x82F63B78U : 0U);
  }
  return ~crc;
}

TEST(Crc32c, IsTheDefinitionsForEveryLengthAndAlignment) {
  std::vector<std::byte> bytes(80);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * i * 31 + 7);
  for (std::size_t first = 0; first < 9; ++first) {
    for (std::size_t length = 0; first + length <= bytes.size(); ++length) {
      const auto part = std::span(bytes).subspan(first, length);
      ASSERT_EQ(crc32c(part), bit_by_bit(part)) << first << " " << length;
    }
  }
}

}  // namespace
}  // namespace tonus
