#include "services/store/coverage.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <set>

namespace tonus::store {
namespace {

TEST(Coverage, IsOneRangeWhateverTheOrderOfArrival) {
  std::vector<SequenceRange> blocks;
  for (std::uint64_t first = 0; first < 1000; first += 20) blocks.push_back({first, first + 20});
  std::mt19937 generator(3);
  std::shuffle(blocks.begin(), blocks.end(), generator);
  Coverage coverage;
  std::uint64_t fresh = 0;
  for (const auto& block : blocks) fresh += coverage.add(block);
  EXPECT_EQ(fresh, 1000U);
  EXPECT_EQ(coverage.ranges(), (std::vector<SequenceRange>{{0, 1000}}));
}

TEST(Coverage, CountsRepetitionsAsNothingNew) {
  Coverage coverage;
  EXPECT_EQ(coverage.add({10, 30}), 20U);
  EXPECT_EQ(coverage.add({10, 30}), 0U);
  EXPECT_EQ(coverage.add({25, 35}), 5U);
  EXPECT_EQ(coverage.add({0, 100}), 75U);
  EXPECT_EQ(coverage.ranges(), (std::vector<SequenceRange>{{0, 100}}));
}

TEST(Coverage, NamesTheGaps) {
  Coverage coverage;
  coverage.add({10, 20});
  coverage.add({40, 50});
  coverage.add({30, 35});
  EXPECT_EQ(coverage.missing({0, 60}), (std::vector<SequenceRange>{{0, 10}, {20, 30}, {35, 40}, {50, 60}}));
  EXPECT_EQ(coverage.missing({12, 33}), (std::vector<SequenceRange>{{20, 30}}));
  EXPECT_EQ(coverage.missing({0, 60}, 2), (std::vector<SequenceRange>{{0, 10}, {20, 30}}));
  EXPECT_TRUE(coverage.missing({10, 20}).empty());
  EXPECT_TRUE(coverage.missing({20, 20}).empty());
  EXPECT_EQ(coverage.first_missing(0), 0U);
  EXPECT_EQ(coverage.first_missing(10), 20U);
  EXPECT_TRUE(coverage.covers({12, 18}));
  EXPECT_TRUE(coverage.covers({25, 25}));
  EXPECT_FALSE(coverage.covers({12, 21}));
}

TEST(Coverage, AgreesWithASetOfNumbers) {
  std::mt19937 generator(11);
  std::uniform_int_distribution<std::uint64_t> number(0, 200);
  std::uniform_int_distribution<std::uint64_t> length(0, 15);
  for (int round = 0; round < 200; ++round) {
    Coverage coverage;
    std::set<std::uint64_t> numbers;
    for (int i = 0; i < 30; ++i) {
      const std::uint64_t first = number(generator);
      const SequenceRange range{first, first + length(generator)};
      std::uint64_t fresh = 0;
      for (std::uint64_t n = range.first; n < range.end; ++n) fresh += numbers.insert(n).second ? 1U : 0U;
      ASSERT_EQ(coverage.add(range), fresh);
      const std::uint64_t from = number(generator);
      const SequenceRange asked{from, from + 3 * length(generator)};
      std::uint64_t inside = 0;
      for (std::uint64_t n = asked.first; n < asked.end; ++n) inside += numbers.count(n);
      ASSERT_EQ(coverage.count_in(asked), inside);
      std::uint64_t missing = asked.count();
      for (const auto& gap : coverage.missing(asked)) {
        for (std::uint64_t n = gap.first; n < gap.end; ++n) ASSERT_FALSE(numbers.contains(n));
        missing -= gap.count();
      }
      ASSERT_EQ(missing, inside);
      std::uint64_t next = from;
      while (numbers.contains(next)) ++next;
      ASSERT_EQ(coverage.first_missing(from), next);
    }
    for (std::size_t i = 1; i < coverage.ranges().size(); ++i) {
      ASSERT_LT(coverage.ranges()[i - 1].end, coverage.ranges()[i].first);
    }
    ASSERT_EQ(coverage.end(), numbers.empty() ? 0 : *numbers.rbegin() + 1);
  }
}

TEST(Coverage, HasInCommonWithAnotherWhatIsInBoth) {
  Coverage a;
  for (const SequenceRange& range : {SequenceRange{0, 10}, {20, 30}, {40, 50}}) a.add(range);
  Coverage b;
  for (const SequenceRange& range : {SequenceRange{5, 25}, {28, 41}, {50, 60}}) b.add(range);
  const std::vector<SequenceRange> both{{5, 10}, {20, 25}, {28, 30}, {40, 41}};
  EXPECT_EQ(a.common(b).ranges(), both);
  EXPECT_EQ(b.common(a).ranges(), both);
  EXPECT_TRUE(a.common(Coverage()).ranges().empty());
}

}  // namespace
}  // namespace tonus::store
