#include "services/contract/sequence.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "services/contract/certificate.hpp"

namespace tonus {
namespace {

TEST(SequenceRange, FromFirstToLastHoldsBoth) {
  const auto range = SequenceRange::from_first_to_last(10, 12);
  EXPECT_EQ(range, (SequenceRange{10, 13}));
  EXPECT_EQ(range.count(), 3U);
  EXPECT_EQ(range.last(), 12U);
  EXPECT_TRUE(range.contains(10));
  EXPECT_TRUE(range.contains(12));
  EXPECT_FALSE(range.contains(13));
}

TEST(SequenceRange, ALastNumberBeforeTheFirstOrWithoutASuccessorIsEmpty) {
  EXPECT_TRUE(SequenceRange::from_first_to_last(10, 8).is_empty());
  EXPECT_TRUE(SequenceRange::from_first_to_last(10, std::numeric_limits<std::uint64_t>::max()).is_empty());
}

TEST(Certificate, SumsEveryCount) {
  Certificate sum{10, 9, 8, 7, 6};
  sum += Certificate{1, 2, 3, 4, 5};
  EXPECT_EQ(sum, (Certificate{11, 11, 11, 11, 11}));
}

}  // namespace
}  // namespace tonus
