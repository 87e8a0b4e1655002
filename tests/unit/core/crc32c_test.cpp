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

}  // namespace
}  // namespace tonus
