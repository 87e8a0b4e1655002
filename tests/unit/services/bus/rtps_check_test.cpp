#include "services/bus/fastdds/rtps_check.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <set>

#include "tests/support/bus/rtps_packet.hpp"

namespace tonus::bus {
namespace {

using test::kParticipantWriter;
using test::kPublicationsWriter;
using test::kUserWriter;
using test::RtpsPacket;
using Bytes = RtpsPacket::Bytes;

RtpsFault fault_of(const Bytes& bytes) { return check_rtps(bytes).fault; }
RtpsFault fault_of(const RtpsPacket& packet) { return fault_of(packet.bytes()); }

Bytes with_byte(Bytes bytes, std::size_t at, std::uint8_t value) {
  bytes.at(at) = static_cast<std::byte>(value);
  return bytes;
}

class RtpsCheck : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(ByteOrder, RtpsCheck, testing::Bool(), [](const auto& one) {
  return one.param ? std::string("little_endian") : std::string("big_endian");
});

TEST_P(RtpsCheck, TakesEveryKindOfGoodPacketWhole) {
  for (const auto& [name, packet] : test::good_rtps_packets(GetParam())) {
    SCOPED_TRACE(name);
    const RtpsChecked checked = check_rtps(packet.bytes());
    EXPECT_EQ(text_of(checked.fault), text_of(RtpsFault::kNone));
    EXPECT_EQ(checked.message.size(), packet.bytes().size());
    EXPECT_TRUE(checked.patches.empty());
  }
}

TEST_P(RtpsCheck, TakesAllKindsOfSubmessageInOnePacket) {
  RtpsPacket all(GetParam());
  for (const auto& [name, packet] : test::good_rtps_packets(GetParam()))
    all.bytes().insert(all.bytes().end(), packet.bytes().begin() + 20, packet.bytes().end());

  const RtpsChecked checked = check_rtps(all.bytes());

  EXPECT_EQ(text_of(checked.fault), text_of(RtpsFault::kNone));
  EXPECT_EQ(checked.message.size(), all.bytes().size());
}

TEST_P(RtpsCheck, RefusesEveryKindOfPacketCutShortAnywhere) {
  for (const auto& [name, packet] : test::good_rtps_packets(GetParam())) {
    for (std::size_t size = 0; size < packet.bytes().size(); ++size) {
      SCOPED_TRACE(name + " cut to " + std::to_string(size));
      const Bytes cut(packet.bytes().begin(), packet.bytes().begin() + static_cast<std::ptrdiff_t>(size));
      const bool is_bare_header = size == 20;
      EXPECT_EQ(fault_of(cut) == RtpsFault::kNone, is_bare_header);
    }
  }
}

/// A parser reads no byte of the copy behind its end without the sanitizers' knowledge: worth most there.
TEST_P(RtpsCheck, ReadsNothingBehindTheEndWhateverTheBytes) {
  std::mt19937_64 random(20260101);
  for (const auto& [name, packet] : test::good_rtps_packets(GetParam())) {
    for (int i = 0; i < 2000; ++i) {
      Bytes bytes = packet.bytes();
      for (int flips = 0; flips < 3; ++flips)
        bytes[20 + random() % (bytes.size() - 20)] = static_cast<std::byte>(random());
      bytes.resize(20 + random() % (bytes.size() - 19));
      bytes.shrink_to_fit();
      const RtpsChecked checked = check_rtps(bytes);
      ASSERT_LE(checked.message.size(), bytes.size());
      for (const BytePatch& patch : checked.patches) ASSERT_LE(patch.at + patch.count, bytes.size());
    }
  }
}

TEST_P(RtpsCheck, RefusesASubmessageWhoseLengthLeadsOutOfThePacket) {
  for (const auto& [name, packet] : test::good_rtps_packets(GetParam())) {
    SCOPED_TRACE(name);
    EXPECT_EQ(fault_of(with_byte(packet.bytes(), GetParam() ? 23 : 22, 0x7f)), RtpsFault::kLength);
  }
}

TEST_P(RtpsCheck, RefusesEverySubmessageThatRtpsDoesNotDefine) {
  const std::set<int> defined{0x01, 0x06, 0x07, 0x08, 0x09, 0x0c, 0x0d, 0x0e, 0x0f,
                              0x12, 0x13, 0x15, 0x16, 0x30, 0x31, 0x32, 0x33, 0x34};
  for (int id = 0; id < 256; ++id) {
    if (defined.contains(id)) continue;
    SCOPED_TRACE(id);
    RtpsPacket amid(GetParam());
    amid.submessage(static_cast<std::uint8_t>(id), 0, [](RtpsPacket& p) { p.zeros(56); })
        .submessage(0x0e, 0, [](RtpsPacket& p) { p.zeros(12); });
    EXPECT_EQ(fault_of(amid), RtpsFault::kSubmessage);
  }
}

TEST_P(RtpsCheck, CutsOffTheStatisticsThatFastDdsAppendsWhateverTheyHold) {
  for (const std::size_t size : {0U, 4U, 48U, 56U, 60U}) {
    RtpsPacket packet(GetParam());
    packet.submessage(0x0e, 0, [](RtpsPacket& p) { p.zeros(12); });
    const std::size_t end = packet.bytes().size();
    packet.submessage(0x80, 0, [size](RtpsPacket& p) { p.zeros(size); });

    const RtpsChecked checked = check_rtps(packet.bytes());

    EXPECT_EQ(text_of(checked.fault), text_of(RtpsFault::kNone));
    EXPECT_EQ(checked.message.size(), end);
  }
}

TEST(RtpsCheckOfHeaders, RefusesThePacketThatEndsAFastDdsProcess) {
  EXPECT_EQ(test::statistics_amid_packet().bytes().size(), 92U);
  EXPECT_EQ(fault_of(test::statistics_amid_packet()), RtpsFault::kSubmessage);
}

TEST(RtpsCheckOfHeaders, RefusesWhatIsNotRtpsOfVersionTwo) {
  const Bytes good = test::good_rtps_packets(true).front().second.bytes();
  for (std::size_t at = 0; at < 4; ++at) EXPECT_EQ(fault_of(with_byte(good, at, 'X')), RtpsFault::kHeader);
  for (const std::uint8_t version : std::vector<std::uint8_t>{0, 1, 3, 255})
    EXPECT_EQ(fault_of(with_byte(good, 4, version)), RtpsFault::kVersion);
  EXPECT_EQ(fault_of(Bytes{}), RtpsFault::kHeader);
}

/// One submessage with a fault inside, in both byte orders.
void expect_contents_fault(std::uint8_t id, const RtpsPacket::Fill& fill) {
  for (const bool is_little_endian : {true, false}) {
    RtpsPacket packet(is_little_endian);
    packet.submessage(id, 0, fill);
    EXPECT_EQ(text_of(fault_of(packet)), text_of(RtpsFault::kContents));
  }
}

RtpsPacket& entities(RtpsPacket& packet) { return packet.entity(0).entity(kUserWriter); }

TEST(RtpsCheckOfNumbers, RefusesSetsOfMoreBitsThanRtpsAllows) {
  expect_contents_fault(0x06,
                        [](RtpsPacket& p) { entities(p).sequence_number(1).u32(257).zeros(36).u32(1); });
  expect_contents_fault(0x08, [](RtpsPacket& p) {
    entities(p).sequence_number(1).sequence_number(2).u32(0xffffffff).zeros(64);
  });
  expect_contents_fault(
      0x12, [](RtpsPacket& p) { entities(p).sequence_number(1).u32(1).u32(300).zeros(44).u32(1); });
}

TEST(RtpsCheckOfNumbers, RefusesGapsThatWouldBeCountedThroughForHours) {
  const auto gap = [](std::int64_t start, std::int64_t base) {
    RtpsPacket packet;
    packet.submessage(
        0x08, 0, [=](RtpsPacket& p) { entities(p).sequence_number(start).sequence_number(base).u32(0); });
    return fault_of(packet);
  };
  EXPECT_EQ(gap(1, 200'000), RtpsFault::kNone);
  EXPECT_EQ(gap(1LL << 40, (1LL << 40) + 10), RtpsFault::kNone);
  for (const auto& [start, base] : std::vector<std::pair<std::int64_t, std::int64_t>>{
           {1, 1LL << 20}, {1, 1LL << 40}, {1, INT64_MAX}, {9, 8}, {0, 5}, {-5, 5}, {INT64_MIN, INT64_MAX}}) {
    EXPECT_EQ(gap(start, base), RtpsFault::kContents) << start << " to " << base;
  }
}

TEST(RtpsCheckOfNumbers, RefusesHeartbeatsThatEndBeforeTheyBegin) {
  expect_contents_fault(0x07,
                        [](RtpsPacket& p) { entities(p).sequence_number(9).sequence_number(7).u32(1); });
  expect_contents_fault(0x07,
                        [](RtpsPacket& p) { entities(p).sequence_number(-1).sequence_number(7).u32(1); });
}

struct Fragment {
  std::uint32_t first = 1;
  std::uint16_t count = 1;
  std::uint16_t size = 128;
  std::uint32_t sample_bytes = 300;
  std::size_t payload = 128;
};

RtpsFault fault_of(const Fragment& fragment, const RtpsLimits& limits = {}) {
  RtpsPacket packet;
  packet.submessage(0x16, 0, [&](RtpsPacket& p) {
    p.u16(0).u16(28);
    entities(p).sequence_number(1).u32(fragment.first).u16(fragment.count).u16(fragment.size);
    p.u32(fragment.sample_bytes).zeros(fragment.payload);
  });
  return check_rtps(packet.bytes(), limits).fault;
}

TEST(RtpsCheckOfFragments, RefusesThoseThatLeadOutOfTheirSampleOrTakeMemoryWithoutLimit) {
  EXPECT_EQ(fault_of(Fragment{}), RtpsFault::kNone);
  EXPECT_EQ(fault_of(Fragment{.first = 3, .payload = 44}), RtpsFault::kNone);  // the last one is short
  EXPECT_EQ(fault_of(Fragment{.count = 3, .payload = 300}), RtpsFault::kNone);
  for (const Fragment& bad :
       {Fragment{.first = 0}, Fragment{.first = 4}, Fragment{.first = 0xffffffff}, Fragment{.count = 0},
        Fragment{.count = 4, .payload = 512}, Fragment{.size = 0}, Fragment{.size = 1}, Fragment{.size = 16},
        Fragment{.sample_bytes = 0}, Fragment{.sample_bytes = 0xffffffff}, Fragment{.payload = 127},
        Fragment{.first = 3, .payload = 43}, Fragment{.sample_bytes = 257}}) {
    EXPECT_EQ(fault_of(bad), RtpsFault::kContents)
        << bad.first << " " << bad.count << " " << bad.size << " " << bad.sample_bytes << " " << bad.payload;
  }
}

TEST(RtpsCheckOfFragments, TakesSamplesUpToTheLargestOfTheReadersTopics) {
  const Fragment large{.size = 16000, .sample_bytes = 100'000, .payload = 16000};
  EXPECT_EQ(fault_of(large), RtpsFault::kContents);
  EXPECT_EQ(fault_of(large, {.message_bytes = 100'000}), RtpsFault::kNone);
}

TEST(RtpsCheckOfData, RefusesPlacesOfInlineQosThatLeadOutOfTheSubmessage) {
  for (const std::uint16_t octets :
       std::vector<std::uint16_t>{0, 4, 12, 15, 18, 200, 0x7fff, 0x8000, 0xffff}) {
    expect_contents_fault(0x15, [octets](RtpsPacket& p) {
      p.u16(0).u16(octets);
      entities(p).sequence_number(1).zeros(64);
    });
  }
}

TEST(RtpsCheckOfData, RefusesInlineQosThatDoesNotEnd) {
  for (const std::uint16_t length : std::vector<std::uint16_t>{2, 3, 28, 0xfffc, 0xffff}) {
    RtpsPacket packet;
    packet.data(kUserWriter, 2 | 4, [length](RtpsPacket& p) { p.u16(0x800f).u16(length).zeros(24); });
    EXPECT_EQ(fault_of(packet), RtpsFault::kParameters) << length;
  }
}

TEST(RtpsCheckOfData, RefusesDataAndKeyAtOnceAndNumbersBelowOne) {
  RtpsPacket both;
  both.data(kUserWriter, 4 | 8, [](RtpsPacket& p) { p.zeros(24); });
  EXPECT_EQ(fault_of(both), RtpsFault::kFlags);
  for (const std::int64_t number : {std::int64_t{0}, std::int64_t{-1}, INT64_MIN}) {
    expect_contents_fault(0x15, [number](RtpsPacket& p) {
      p.u16(0).u16(16);
      entities(p).sequence_number(number).zeros(24);
    });
  }
}

RtpsFault fault_of_parameter(std::uint16_t id, const RtpsPacket::Fill& value, bool is_little_endian = true) {
  RtpsPacket packet(is_little_endian);
  packet.discovery(kPublicationsWriter, [&](RtpsPacket& p) { p.parameter(id, value); });
  return fault_of(packet);
}

TEST(RtpsCheckOfDiscovery, RefusesTextsSequencesAndPropertiesThatLeaveTheirParameter) {
  constexpr std::uint32_t kHuge = 0xfffffff0;
  const std::vector<std::pair<std::uint16_t, RtpsPacket::Fill>> bad{
      {0x0005, [](RtpsPacket& p) { p.u32(kHuge).zeros(12); }},                  // topic name
      {0x0007, [](RtpsPacket& p) { p.u32(20).zeros(12); }},                     // type name
      {0x0007, [](RtpsPacket& p) { p.u32(4).u32(0x41414141); }},                // without its zero
      {0x0062, [](RtpsPacket& p) { p.string(std::string(256, 'n')); }},         // longer than Fast DDS keeps
      {0x002c, [](RtpsPacket& p) { p.u32(kHuge).zeros(4); }},                   // user data
      {0x0029, [](RtpsPacket& p) { p.u32(kHuge).string("a"); }},                // partitions
      {0x0029, [](RtpsPacket& p) { p.u32(2).string("a"); }},                    // one of two
      {0x0059, [](RtpsPacket& p) { p.u32(kHuge).string("a").string("b"); }},    // properties
      {0x0059, [](RtpsPacket& p) { p.u32(1).string("a").u32(kHuge).u32(0); }},  // a property's value
      {0x0073, [](RtpsPacket& p) { p.u32(kHuge).u32(0); }},                     // data representation
      {0x0073, [](RtpsPacket& p) { p.u32(3).u32(0); }},                         //
      {0x1001, [](RtpsPacket& p) { p.string("class").u32(kHuge); }},            // identity token
      {0x1001, [](RtpsPacket& p) { p.string("class").u32(0).u32(1).string("n").u32(kHuge); }},
      {0x0035, [](RtpsPacket& p) { p.string("a").string("b").string("c").string("d").u32(kHuge); }}};
  for (const bool is_little_endian : {true, false}) {
    for (std::size_t i = 0; i < bad.size(); ++i) {
      EXPECT_EQ(text_of(fault_of_parameter(bad[i].first, bad[i].second, is_little_endian)),
                text_of(RtpsFault::kParameters))
          << "case " << i;
    }
  }
}

TEST(RtpsCheckOfDiscovery, RefusesWhatHasAFixedSizeInAnyOther) {
  for (const std::uint16_t id : std::vector<std::uint16_t>{
           0x0002, 0x0015, 0x001a, 0x001b, 0x001d, 0x001e, 0x001f, 0x0021, 0x0023, 0x0025, 0x002f, 0x0031,
           0x0032, 0x0033, 0x0048, 0x0050, 0x0058, 0x005a, 0x0070}) {
    EXPECT_EQ(fault_of_parameter(id, [](RtpsPacket& p) { p.zeros(400); }), RtpsFault::kParameters) << id;
    EXPECT_EQ(fault_of_parameter(id, [](RtpsPacket&) {}), RtpsFault::kParameters) << id;
  }
}

TEST(RtpsCheckOfDiscovery, RefusesWhatIsNoParameterListWhetherReaderOrWriterIsOfDiscovery) {
  for (const auto& [reader, writer] :
       std::vector<std::pair<std::uint32_t, std::uint32_t>>{{0, kParticipantWriter},
                                                            {0x000100c7, kUserWriter},
                                                            {0x000003c7, 0},
                                                            {0x000004c7, kPublicationsWriter}}) {
    RtpsPacket packet;
    packet.submessage(0x15, 4, [&](RtpsPacket& p) {
      p.u16(0).u16(16).entity(reader).entity(writer).sequence_number(1).u8(0).u8(1).zeros(60);
    });
    EXPECT_EQ(fault_of(packet), RtpsFault::kParameters);
  }
}

/// Parameters of the good packet, by id and value.
std::vector<std::pair<std::uint16_t, std::vector<std::byte>>> parameters_of(std::span<const std::byte> list) {
  std::vector<std::pair<std::uint16_t, std::vector<std::byte>>> all;
  ByteCursor cursor(list, true);
  while (!cursor.has_failed()) {
    const std::uint16_t id = cursor.u16();
    const auto value = cursor.take(cursor.u16());
    if (cursor.has_failed() || id == 1) break;
    all.emplace_back(id, std::vector<std::byte>(value.begin(), value.end()));
  }
  return all;
}

TEST(RtpsCheckOfDiscovery, TurnsTypeDescriptionsAndSharedMemoryIntoPadding) {
  for (const std::uint16_t id : std::vector<std::uint16_t>{0x0069, 0x0072, 0x0075, 0x8006}) {
    RtpsPacket packet;
    packet.discovery(kPublicationsWriter, [id](RtpsPacket& p) {
      p.parameter(0x0005, [](RtpsPacket& q) { q.string("rig/state"); });
      p.parameter(id, [](RtpsPacket& q) { q.u32(0xffffffff).zeros(12); });
    });
    const RtpsChecked checked = check_rtps(packet.bytes());
    ASSERT_EQ(checked.fault, RtpsFault::kNone);
    ASSERT_EQ(checked.patches.size(), 1U);
    Bytes patched = packet.bytes();
    std::copy_n(checked.patches[0].bytes.begin(), checked.patches[0].count,
                patched.begin() + static_cast<std::ptrdiff_t>(checked.patches[0].at));

    const auto parameters = parameters_of(std::span(patched).subspan(48));

    ASSERT_EQ(parameters.size(), 2U);
    EXPECT_EQ(parameters[0].first, 0x0005);
    EXPECT_EQ(parameters[1].first, 0x0000);
  }
}

TEST(RtpsCheckOfDiscovery, ShortensLeasesSoThatAPeerThatFellSilentIsForgotten) {
  for (const std::uint32_t seconds : std::vector<std::uint32_t>{21U, 100U, 0x7fffffffU, 0xffffffffU}) {
    RtpsPacket packet;
    packet.discovery(kParticipantWriter, [seconds](RtpsPacket& p) {
      p.parameter(0x0002, [seconds](RtpsPacket& q) { q.u32(seconds).u32(0); });
    });
    const RtpsChecked checked = check_rtps(packet.bytes());
    ASSERT_EQ(checked.patches.size(), 1U) << seconds;
    Bytes patched = packet.bytes();
    std::copy_n(checked.patches[0].bytes.begin(), checked.patches[0].count,
                patched.begin() + static_cast<std::ptrdiff_t>(checked.patches[0].at));
    const auto parameters = parameters_of(std::span(patched).subspan(48));
    ASSERT_EQ(parameters.size(), 1U);
    EXPECT_EQ(ByteCursor(parameters[0].second, true).u32(), 20U);
  }
}

}  // namespace
}  // namespace tonus::bus
