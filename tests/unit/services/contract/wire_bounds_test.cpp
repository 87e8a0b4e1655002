// Bounds of the wire types: what a length in a payload may cost before it is refused.

#include <cstdint>
#include <cstring>
#include <gtest/gtest.h>
#include <string>
#include <tuple>

#include "idl/topics.hpp"
#include "tests/support/allocations.hpp"

namespace tonus {
namespace {

/// More than the largest value within its bounds takes in one piece, with room for an error's text.
constexpr std::size_t kMostAtOnce = 128U * 1024U;

/// Calls `use` with a payload in which every place where a length may stand is `length` in turn.
template <typename T, typename Use>
void with_length_everywhere(const bus::Topic<T>& topic, std::size_t bytes, std::uint32_t length,
                            const Use& use) {
  bus::Payload payload = *bus::encode(T());
  payload.resize(std::max(payload.size(), std::min<std::size_t>(bytes, topic.spec.max_payload_bytes)));
  const std::size_t end = std::min<std::size_t>(payload.size(), 2048);
  for (std::size_t place = 20; place + sizeof length <= end; place += sizeof length) {
    bus::Payload damaged = payload;
    std::memcpy(damaged.data() + place, &length, sizeof length);
    use(topic, damaged, place);
  }
}

template <typename Use>
void for_every_topic(const Use& use) {
  std::apply([&use](const auto&... topic) { (use(topic), ...); }, topics::kTyped);
}

TEST(WireBounds, HoldBeforeMemoryIsTakenForAnyLengthInAnyType) {
  if (!testing::counts_allocations()) GTEST_SKIP() << "a sanitizer brings its own malloc";
  for (const std::uint32_t length : {60'000U, 0x04000000U, 0xFFFFFFFFU}) {
    for (const std::size_t bytes : {0U, 60'000U}) {
      for_every_topic([&](const auto& topic) {
        with_length_everywhere(
            topic, bytes, length, [&](const auto& its_topic, const bus::Payload& payload, std::size_t place) {
              testing::forget_allocations();
              const auto checked = topics::decode_any(its_topic.spec, payload, [](const auto&) {});
              ASSERT_LE(testing::largest_allocation(), kMostAtOnce)
                  << its_topic.spec.name << " with " << length << " at byte " << place << " of "
                  << payload.size();
              (void)checked;
            });
      });
    }
  }
}

TEST(WireBounds, HoldForWhatIsSent) {
  v1::ServiceHealth health;
  health.warnings(std::vector<std::string>(17));
  const auto payload = bus::encode(health);
  ASSERT_FALSE(payload);
  EXPECT_EQ(payload.error().message, "ServiceHealth.warnings is 17, at most 16 is allowed");
  v1::Estimate estimate;
  estimate.checks(std::vector<v1::FitCheck>(1));
  estimate.checks()[0].test(static_cast<v1::FitTest>(v1::FIT_WIDTH + 1));
  EXPECT_FALSE(bus::encode(estimate)) << "an enumerator within an element of a sequence";
}

TEST(WireBounds, RefuseAnEnumeratorOfANewerContractWhereverItStands) {
  v1::TrialVerdict verdict;
  verdict.reasons({v1::REASON_LET_GO});
  auto payload = *bus::encode(verdict);
  ASSERT_TRUE(bus::decode<v1::TrialVerdict>(payload));
  // header 4, ids 32, three counts 12, is_valid 1, padding 3, length 4
  const std::uint32_t unknown = v1::REASON_REJECTED_BY_HAND + 1;
  std::memcpy(payload.data() + 56, &unknown, sizeof unknown);
  EXPECT_FALSE(bus::decode<v1::TrialVerdict>(payload));
}

}  // namespace
}  // namespace tonus
