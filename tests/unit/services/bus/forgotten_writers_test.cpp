#include "services/bus/fastdds/forgotten_writers.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "tests/support/bus/rtps_packet.hpp"

namespace tonus::bus {
namespace {

using test::RtpsPacket;
using Bytes = RtpsPacket::Bytes;

constexpr std::uint32_t kReader = 0x000003c7;
constexpr std::uint32_t kCount = 41;

/// An acknowledgement that lacks three numbers from `base` on, and says that it wants no answer.
RtpsPacket acknowledgement(std::int64_t base, bool is_little_endian = true, std::uint8_t participant = 7,
                           std::uint32_t writer = test::kPublicationsWriter) {
  RtpsPacket packet(is_little_endian);
  packet.bytes()[8] = static_cast<std::byte>(participant);
  return packet.submessage(0x06, 2, [=](RtpsPacket& p) {
    p.entity(kReader).entity(writer).sequence_number(base).u32(3).u32(0xe0000000).u32(kCount);
  });
}

/// The packet as Fast DDS gets to see it.
Bytes seen(ForgottenWriters& forgotten, const RtpsPacket& packet) {
  RtpsChecked checked = check_rtps(packet.bytes());
  EXPECT_EQ(checked.fault, RtpsFault::kNone);
  for (const Acknowledgement& word : checked.acknowledgements)
    forgotten.see(word, packet.bytes(), checked.patches);
  Bytes bytes = packet.bytes();
  for (const BytePatch& patch : checked.patches)
    std::copy_n(patch.bytes.begin(), patch.count, bytes.begin() + static_cast<std::ptrdiff_t>(patch.at));
  return bytes;
}

class ForgottenWritersOfBothOrders : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(ByteOrder, ForgottenWritersOfBothOrders, testing::Bool(), [](const auto& one) {
  return one.param ? std::string("little_endian") : std::string("big_endian");
});

TEST_P(ForgottenWritersOfBothOrders, AReaderThatAsksForWhatItHadBeginsAnew) {
  ForgottenWriters forgotten;
  (void)seen(forgotten, acknowledgement(9, GetParam()));

  const Bytes bytes = seen(forgotten, acknowledgement(1, GetParam()));

  EXPECT_EQ(check_rtps(bytes).fault, RtpsFault::kNone);
  EXPECT_EQ(bytes[21], GetParam() ? std::byte{1} : std::byte{0});  // byte order alone: an answer is wanted
  ByteCursor cursor(std::span<const std::byte>(bytes).subspan(24), GetParam());
  cursor.skip(8);
  EXPECT_EQ(cursor.sequence_number(), 0);
  EXPECT_EQ(cursor.u32(), 0U);  // bits
  EXPECT_EQ(cursor.u32(), kCount);
}

TEST_P(ForgottenWritersOfBothOrders, AcknowledgementsThatGoForwardStayAsTheyAre) {
  ForgottenWriters forgotten;
  for (const std::int64_t base : {0, 1, 1, 5, 5, 9}) {
    const RtpsPacket packet = acknowledgement(base, GetParam());
    EXPECT_EQ(seen(forgotten, packet), packet.bytes()) << base;
  }
}

TEST(ForgottenWriters, AfterItsFirstWordAReaderIsAnsweredAsAnyOther) {
  ForgottenWriters forgotten;
  (void)seen(forgotten, acknowledgement(9));
  (void)seen(forgotten, acknowledgement(1));
  EXPECT_EQ(seen(forgotten, acknowledgement(1)), acknowledgement(1).bytes());
  EXPECT_EQ(seen(forgotten, acknowledgement(4)), acknowledgement(4).bytes());
}

TEST(ForgottenWriters, TellsReadersAndWritersApart) {
  ForgottenWriters forgotten;
  (void)seen(forgotten, acknowledgement(9));
  const RtpsPacket of_another_participant = acknowledgement(1, true, 8);
  const RtpsPacket of_another_writer = acknowledgement(1, true, 7, 0x000004c2);
  EXPECT_EQ(seen(forgotten, of_another_participant), of_another_participant.bytes());
  EXPECT_EQ(seen(forgotten, of_another_writer), of_another_writer.bytes());
}

TEST(ForgottenWriters, LeavesWritersOfApplicationsAlone) {
  ForgottenWriters forgotten;
  (void)seen(forgotten, acknowledgement(9, true, 7, test::kUserWriter));
  const RtpsPacket packet = acknowledgement(1, true, 7, test::kUserWriter);
  EXPECT_EQ(seen(forgotten, packet), packet.bytes());
}

}  // namespace
}  // namespace tonus::bus
