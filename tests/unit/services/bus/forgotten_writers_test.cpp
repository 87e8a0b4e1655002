#include "services/bus/fastdds/forgotten_writers.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "tests/support/bus/rtps_packet.hpp"

namespace tonus::bus {
namespace {

using test::RtpsPacket;
using Bytes = RtpsPacket::Bytes;

constexpr std::uint32_t kReader = 0x000003c7;

struct Word {
  std::int64_t base = 1;
  std::uint32_t count = 1;
  bool is_little_endian = true;
  std::uint8_t participant = 7;
  std::uint32_t writer = test::kPublicationsWriter;
  bool asks = true;
};

/// An acknowledgement that says that it wants no answer; one that asks lacks three numbers from its base on.
RtpsPacket acknowledgement(const Word& word) {
  RtpsPacket packet(word.is_little_endian);
  packet.bytes()[8] = static_cast<std::byte>(word.participant);
  return packet.submessage(0x06, 2, [=](RtpsPacket& p) {
    p.entity(kReader).entity(word.writer).sequence_number(word.base);
    if (word.asks) p.u32(3).u32(0xe0000000);
    if (!word.asks) p.u32(0);
    p.u32(word.count);
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

/// The count of the one acknowledgement in a packet.
std::uint32_t count_in(const Bytes& bytes) {
  const RtpsChecked checked = check_rtps(bytes);
  EXPECT_EQ(checked.acknowledgements.size(), 1U);
  return checked.acknowledgements.empty() ? 0 : checked.acknowledgements.front().count;
}

/// Whether it is the empty request that a new reader begins with.
bool is_first_word(const Bytes& bytes) {
  const RtpsChecked checked = check_rtps(bytes);
  EXPECT_EQ(checked.acknowledgements.size(), 1U);
  if (checked.acknowledgements.empty()) return false;
  const Acknowledgement& word = checked.acknowledgements.front();
  return word.base == 0 && !word.asks && (bytes[21] & std::byte{2}) == std::byte{0};
}

class ForgottenWritersOfBothOrders : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(ByteOrder, ForgottenWritersOfBothOrders, testing::Bool(), [](const auto& one) {
  return one.param ? std::string("little_endian") : std::string("big_endian");
});

TEST_P(ForgottenWritersOfBothOrders, AReaderThatAsksForWhatItHadBeginsAnew) {
  ForgottenWriters forgotten;
  (void)seen(forgotten, acknowledgement({.base = 9, .count = 40, .is_little_endian = GetParam()}));

  const Bytes bytes =
      seen(forgotten, acknowledgement({.base = 1, .count = 41, .is_little_endian = GetParam()}));

  EXPECT_EQ(check_rtps(bytes).fault, RtpsFault::kNone);
  EXPECT_EQ(bytes[21], GetParam() ? std::byte{1} : std::byte{0});  // byte order alone: an answer is wanted
  ByteCursor cursor(std::span<const std::byte>(bytes).subspan(24), GetParam());
  cursor.skip(8);
  EXPECT_EQ(cursor.sequence_number(), 0);
  EXPECT_EQ(cursor.u32(), 0U);  // bits
  EXPECT_EQ(cursor.u32(), 41U);
}

TEST_P(ForgottenWritersOfBothOrders, AcknowledgementsThatGoForwardStayAsTheyAre) {
  ForgottenWriters forgotten;
  std::uint32_t count = 0;
  for (const std::int64_t base : {0, 1, 1, 5, 5, 9}) {
    const RtpsPacket packet =
        acknowledgement({.base = base, .count = ++count, .is_little_endian = GetParam()});
    EXPECT_EQ(seen(forgotten, packet), packet.bytes()) << base;
  }
}

/// Cyclone DDS counts from 1 again after it has dropped a participant and found it anew.
TEST_P(ForgottenWritersOfBothOrders, CountsThatBeginAnewGoOn) {
  ForgottenWriters forgotten;
  (void)seen(forgotten, acknowledgement({.base = 9, .count = 500, .is_little_endian = GetParam()}));
  std::uint32_t last = 500;
  for (std::uint32_t count = 1; count < 6; ++count) {
    const std::uint32_t handed_on = count_in(
        seen(forgotten, acknowledgement({.base = count, .count = count, .is_little_endian = GetParam()})));
    EXPECT_GT(handed_on, last) << count;
    last = handed_on;
  }
}

TEST(ForgottenWriters, AReaderThatCountsAnewAndAsksForWhatItHadBeginsAnewWithACountThatIsTaken) {
  ForgottenWriters forgotten;
  (void)seen(forgotten, acknowledgement({.base = 9, .count = 500}));
  const Bytes bytes = seen(forgotten, acknowledgement({.base = 1, .count = 1}));
  EXPECT_TRUE(is_first_word(bytes));
  EXPECT_GT(count_in(bytes), 500U);
}

TEST(ForgottenWriters, AfterItsFirstWordAReaderIsAnsweredAsAnyOther) {
  ForgottenWriters forgotten;
  (void)seen(forgotten, acknowledgement({.base = 9, .count = 1}));
  (void)seen(forgotten, acknowledgement({.base = 1, .count = 2}));
  const RtpsPacket again = acknowledgement({.base = 1, .count = 3});
  const RtpsPacket further = acknowledgement({.base = 4, .count = 4});
  EXPECT_EQ(seen(forgotten, again), again.bytes());
  EXPECT_EQ(seen(forgotten, further), further.bytes());
}

/// Whatever became of its first word: it may have come while its writer did not know the reader.
TEST(ForgottenWriters, ARequestThatIsRepeatedWithoutEndBeginsAnewNowAndThen) {
  ForgottenWriters forgotten;
  int anew = 0;
  for (std::uint32_t count = 1; count <= 40; ++count)
    anew += is_first_word(seen(forgotten, acknowledgement({.base = 3, .count = count}))) ? 1 : 0;
  EXPECT_GE(anew, 2);
  EXPECT_LE(anew, 10);
}

TEST(ForgottenWriters, AReaderThatLacksNothingMaySaySoForEver) {
  ForgottenWriters forgotten;
  for (std::uint32_t count = 1; count <= 100; ++count) {
    const RtpsPacket packet = acknowledgement({.base = 3, .count = count, .asks = false});
    EXPECT_EQ(seen(forgotten, packet), packet.bytes());
  }
}

TEST(ForgottenWriters, TellsReadersAndWritersApart) {
  ForgottenWriters forgotten;
  (void)seen(forgotten, acknowledgement({.base = 9, .count = 9}));
  const RtpsPacket of_another_participant = acknowledgement({.base = 1, .participant = 8});
  const RtpsPacket of_another_writer = acknowledgement({.base = 1, .writer = 0x000004c2});
  EXPECT_EQ(seen(forgotten, of_another_participant), of_another_participant.bytes());
  EXPECT_EQ(seen(forgotten, of_another_writer), of_another_writer.bytes());
}

/// Their readers of Cyclone DDS forget, too; a writer that keeps a state for late joiners never sent it
/// again.
TEST(ForgottenWriters, ReadersOfApplicationsBeginAnewAsThoseOfDiscoveryDo) {
  ForgottenWriters forgotten;
  (void)seen(forgotten, acknowledgement({.base = 9, .count = 9, .writer = test::kUserWriter}));
  EXPECT_TRUE(
      is_first_word(seen(forgotten, acknowledgement({.base = 1, .count = 1, .writer = test::kUserWriter}))));
}

}  // namespace
}  // namespace tonus::bus
