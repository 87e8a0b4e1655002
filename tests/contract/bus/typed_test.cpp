#include "services/bus/typed.hpp"

#include <cstring>
#include <generated/fast/probe.h>
#include <gtest/gtest.h>
#include <limits>

#include "tests/contract/bus/test_topics.hpp"
#include "tests/support/allocations.hpp"

namespace tonus::bus_test::v1 {

/// What a topic table's owner writes for a type whose bounds matter.
std::string bounds_violation(const ProbePoint& point) {
  return point.x_m() > 1000 ? "x_m " + std::to_string(point.x_m()) + ": at most 1000" : "";
}

}  // namespace tonus::bus_test::v1

namespace tonus::bus {
namespace {

using bus_test::v1::Probe;
using bus_test::v1::ProbePoint;

Probe full_probe() {
  Probe probe;
  probe.probe_id(test::key_of(3));
  probe.sequence_number(0x0102030405060708);
  probe.mode(bus_test::v1::PROBE_RUN);
  probe.note("elbow");
  probe.values({1.5, -2.25, 1e300});
  ProbePoint point;
  point.x_m(0.25);
  point.label("handle");
  probe.points({point, point});
  probe.names({"a", "", "ccc"});
  probe.flags({true, false, true});
  probe.tail(255);
  return probe;
}

/// Where the members after `note` begin: header 4, key 16, number 8 at 24 (aligned to 8 after the header),
/// mode 4, note 4 + 6.
constexpr std::size_t kNumberOffset = 20;

TEST(TypedPayload, HasHeaderKeyAndMembersWhereTheContractPutsThem) {
  const auto bytes = encode(full_probe());

  ASSERT_TRUE(bytes);
  const std::array<std::byte, 4> header{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
  EXPECT_EQ(std::memcmp(bytes->data(), header.data(), 4), 0);
  EXPECT_EQ(std::memcmp(bytes->data() + 4, test::key_of(3).data(), 16), 0);
  EXPECT_EQ(test::number_in(*bytes), 0x0102030405060708U);
  EXPECT_EQ(bytes->size() % 4, 0U);
}

TEST(TypedPayload, ComesBackAsItWas) {
  EXPECT_EQ(*decode<Probe>(*encode(full_probe())), full_probe());
  EXPECT_EQ(*decode<Probe>(*encode(Probe())), Probe());
}

TEST(TypedPayload, IsRefusedWhenCutShortAnywhere) {
  const Payload bytes = *encode(full_probe());
  for (std::size_t size = 0; size + 4 <= bytes.size(); ++size) {
    const auto value = decode<Probe>(std::span(bytes).first(size));
    ASSERT_FALSE(value) << size;
    ASSERT_EQ(value.error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(TypedPayload, IsRefusedWithMoreThanPaddingBehindIt) {
  Payload bytes = *encode(full_probe());
  bytes.resize(bytes.size() + 4);

  const auto value = decode<Probe>(bytes);

  ASSERT_FALSE(value);
  EXPECT_NE(value.error().message.find("padding"), std::string::npos) << value.error().message;
}

TEST(TypedPayload, IsRefusedInAnotherEncapsulation) {
  Payload bytes = *encode(full_probe());
  bytes[1] = std::byte{0};
  EXPECT_FALSE(decode<Probe>(bytes));
}

TEST(TypedPayload, ABoolOfTwoIsRefused) {
  Probe probe = full_probe();
  Payload bytes = *encode(probe);
  // tail is the last member, flags' three bytes precede it; padding follows.
  std::size_t tail = bytes.size() - 1;
  while (bytes[tail] != std::byte{255}) --tail;
  bytes[tail - 1] = std::byte{2};
  EXPECT_FALSE(decode<Probe>(bytes));
}

TEST(TypedPayload, AHugeSequenceLengthIsRefusedWithoutAllocatingForIt) {
  const Payload good = *encode(full_probe());
  for (std::size_t at = kNumberOffset + 8; at + 4 <= good.size(); at += 4) {
    for (const std::uint32_t length :
         {std::numeric_limits<std::uint32_t>::max(), 0x7fffffffU, 0x10000000U, 100000U}) {
      Payload bytes = good;
      std::memcpy(bytes.data() + at, &length, sizeof length);
      testing::forget_allocations();
      static_cast<void>(decode<Probe>(bytes));
      // No element of a sequence is smaller than a byte on the wire; in memory none here is larger than 64.
      ASSERT_LE(testing::largest_allocation(), 64 * bytes.size()) << "length " << length << " at byte " << at;
    }
  }
}

TEST(TypedPayload, RandomMembersAreEitherRefusedOrValuesThatCanBeSentOn) {
  std::uint32_t random = 1;  // fixed seed of a linear congruential generator (Numerical Recipes)
  constexpr int kRounds = 20000;
  int accepted = 0;
  for (int round = 0; round < kRounds; ++round) {
    Payload bytes = *encode(full_probe());
    for (int flips = 0; flips < 4; ++flips) {
      random = random * 1664525U + 1013904223U;
      bytes[kNumberOffset + (random >> 8) % (bytes.size() - kNumberOffset)] =
          static_cast<std::byte>(random >> 24);
    }
    const auto value = decode<Probe>(bytes);
    const auto again = value ? encode(*value) : Result<Payload>(value.error());
    if (!again) continue;
    ++accepted;
    ASSERT_EQ(*encode(*decode<Probe>(*again)), *again);
  }
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, kRounds);
}

TEST(TypedPayload, AValueOutOfItsBoundsIsRefusedOnBothSides) {
  ProbePoint point;
  point.x_m(2000);
  point.label("far enough for a key");
  const auto sent = encode(point);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().message, "x_m 2000.000000: at most 1000");

  point.x_m(10);
  Payload bytes = *encode(point);
  const double far = 3000;
  std::memcpy(bytes.data() + 4, &far, sizeof far);
  EXPECT_FALSE(decode<ProbePoint>(bytes));
}

}  // namespace
}  // namespace tonus::bus
