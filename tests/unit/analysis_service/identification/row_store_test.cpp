#include "analysis_service/identification/row_store.hpp"

#include <gmock/gmock.h>

namespace tonus::identification {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<Row> rows_numbered(std::uint64_t first, std::size_t count) {
  std::vector<Row> rows(count);
  for (std::size_t i = 0; i < count; ++i) rows[i].raw.acquisition_ns = static_cast<std::int64_t>(first + i);
  return rows;
}

std::size_t add(RowStore& store, std::uint64_t first, std::size_t count) {
  return store.add(first, rows_numbered(first, count));
}

TEST(RowStore, JoinsRunsThatAdjoin) {
  RowStore store;
  add(store, 10, 5);
  add(store, 20, 5);
  EXPECT_THAT(store.runs(), ElementsAre(SequenceRange{10, 15}, SequenceRange{20, 25}));
  add(store, 15, 5);
  EXPECT_THAT(store.runs(), ElementsAre(SequenceRange{10, 25}));
  EXPECT_EQ(store.rows(), 15U);
}

TEST(RowStore, TakesOnlyWhatIsNewOfARunThatCoversOthers) {
  RowStore store;
  add(store, 12, 2);
  add(store, 18, 3);
  EXPECT_EQ(add(store, 10, 20), 15U);
  EXPECT_THAT(store.runs(), ElementsAre(SequenceRange{10, 30}));
  EXPECT_EQ(add(store, 10, 20), 0U);
  const auto rows = store.copy({10, 30});
  for (std::size_t i = 0; i < rows.size(); ++i)
    EXPECT_EQ(rows[i].raw.acquisition_ns, 10 + static_cast<int>(i));
}

TEST(RowStore, NamesExactlyWhatIsMissing) {
  RowStore store;
  EXPECT_THAT(store.missing({5, 10}), ElementsAre(SequenceRange{5, 10}));
  add(store, 10, 5);
  add(store, 20, 5);
  EXPECT_THAT(store.missing({8, 31}),
              ElementsAre(SequenceRange{8, 10}, SequenceRange{15, 20}, SequenceRange{25, 31}));
  EXPECT_THAT(store.missing({12, 15}), IsEmpty());
  EXPECT_TRUE(store.holds({10, 15}));
  EXPECT_FALSE(store.holds({10, 16}));
}

TEST(RowStore, MarksRowsThatAreNotHereInACopy) {
  RowStore store;
  add(store, 11, 2);
  const auto rows = store.copy({10, 14});
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_TRUE(rows[0].is_missing);
  EXPECT_FALSE(rows[1].is_missing);
  EXPECT_FALSE(rows[2].is_missing);
  EXPECT_TRUE(rows[3].is_missing);
}

TEST(RowStore, ErasesARangeAcrossRunsAndKeepsTheRest) {
  RowStore store;
  add(store, 10, 10);
  add(store, 30, 10);
  store.erase({15, 35});
  EXPECT_THAT(store.runs(), ElementsAre(SequenceRange{10, 15}, SequenceRange{35, 40}));
  EXPECT_EQ(store.rows(), 10U);
  store.erase({12, 13});
  EXPECT_THAT(store.runs(), ElementsAre(SequenceRange{10, 12}, SequenceRange{13, 15}, SequenceRange{35, 40}));
  EXPECT_EQ(store.rows(), 9U);
}

TEST(RowStore, ErasesNothingForAnEmptyRange) {
  RowStore store;
  add(store, 10, 10);
  store.erase({12, 12});
  EXPECT_THAT(store.runs(), ElementsAre(SequenceRange{10, 20}));
}

TEST(RowStore, GivesRowsUpToTheFirstGap) {
  RowStore store;
  add(store, 10, 5);
  add(store, 16, 5);
  EXPECT_EQ(store.from(12).size(), 3U);
  EXPECT_EQ(store.from(12).front().raw.acquisition_ns, 12);
  EXPECT_TRUE(store.from(15).empty());
}

TEST(RowStore, RefusesNumbersThatCannotBe) {
  RowStore store;
  EXPECT_EQ(store.add(~0ULL - 1, rows_numbered(0, 10)), 0U);
  EXPECT_EQ(store.rows(), 0U);
}

}  // namespace
}  // namespace tonus::identification
