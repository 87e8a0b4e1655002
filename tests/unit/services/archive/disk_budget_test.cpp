#include "services/archive/disk_budget.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace tonus::archive {
namespace {

constexpr std::uint64_t kMB = 1'000'000;

DiskBudget::Options limit_of(std::uint64_t limit_MB, std::uint64_t reserve_MB = 0) {
  DiskBudget::Options options;
  options.limit_bytes = limit_MB * kMB;
  options.reserve_bytes = reserve_MB * kMB;
  return options;
}

DiskBudget::Options reserve_of(std::uint64_t reserve_MB) {
  DiskBudget::Options options;
  options.reserve_bytes = reserve_MB * kMB;
  return options;
}

TEST(DiskBudget, HasRoomWhileNothingIsKnown) {
  DiskBudget budget("study", limit_of(1));
  EXPECT_FALSE(budget.available());
  EXPECT_EQ(budget.refusal(), "");
}

TEST(DiskBudget, LeavesTheReserveFree) {
  DiskBudget budget("study", reserve_of(1000));
  budget.note_space({5 * kMB, 1200 * kMB});
  EXPECT_EQ(budget.available(), 200 * kMB);
  EXPECT_EQ(budget.refusal(), "");
  budget.note_space({205 * kMB, 999 * kMB});
  EXPECT_EQ(budget.available(), 0U);
  EXPECT_EQ(budget.refusal(),
            "store 'study': its disk budget is used up: 999.0 MB are free on its disk, 1.0 GB stay free");
}

TEST(DiskBudget, StopsBeforeItsLimit) {
  DiskBudget budget("study", limit_of(100));
  budget.note_space({94 * kMB, std::nullopt});
  EXPECT_EQ(budget.available(), 1 * kMB);
  budget.note_space({95 * kMB, std::nullopt});
  EXPECT_EQ(budget.refusal(), "store 'study': its disk budget is used up: it has 95.0 MB of 100.0 MB");
}

TEST(DiskBudget, TakesTheNarrowerOfDiskAndLimit) {
  DiskBudget budget("study", limit_of(100, 10));
  budget.note_space({5 * kMB, 50 * kMB});
  EXPECT_EQ(budget.available(), 40 * kMB);
  budget.note_space({5 * kMB, 500 * kMB});
  EXPECT_EQ(budget.available(), 90 * kMB);
}

TEST(DiskBudget, RefusesASessionThatNeedsMoreThanThereIs) {
  DiskBudget budget("study", limit_of(100));
  budget.note_space({0, std::nullopt});
  budget.note_rate(200.0);
  budget.note_session(false, 3600.0);
  EXPECT_EQ(budget.needed(), 86'400'000U);  // 3600 s x 200 Hz x 96 bytes x 1.25
  EXPECT_EQ(budget.refusal(), "");
  budget.note_rate(4000.0);
  EXPECT_EQ(budget.refusal(),
            "store 'study': the session needs about 1.7 GB, 95.0 MB are available: it has 0 B of 100.0 MB");
}

TEST(DiskBudget, GoesByTheBlocksThatCame) {
  DiskBudget budget("study", limit_of(100));
  budget.note_rate(1000.0);
  budget.note_blocks(50'000, 1000);
  budget.note_session(false, 100.0);
  EXPECT_EQ(budget.needed(), 6'250'000U);  // 100 s x 1000 Hz x 50 bytes x 1.25
}

TEST(DiskBudget, LetsASessionThatRunsGoOnUntilNothingIsLeft) {
  DiskBudget budget("study", limit_of(100));
  budget.note_rate(4000.0);
  budget.note_session(true, 3600.0);
  budget.note_space({90 * kMB, std::nullopt});
  EXPECT_EQ(budget.refusal(), "");
  budget.note_space({96 * kMB, std::nullopt});
  EXPECT_NE(budget.refusal(), "");
}

TEST(DiskBudget, ForgetsASessionThatHasEnded) {
  DiskBudget budget("study", limit_of(1));
  budget.note_space({0, std::nullopt});
  budget.note_rate(4000.0);
  budget.note_session(false, 3600.0);
  EXPECT_NE(budget.refusal(), "");
  budget.note_no_session();
  EXPECT_EQ(budget.refusal(), "");
}

TEST(DiskBudget, BearsNonsenseFromTheWire) {
  DiskBudget budget("study", limit_of(1));
  budget.note_space({0, std::nullopt});
  budget.note_rate(std::numeric_limits<double>::quiet_NaN());
  budget.note_session(false, std::numeric_limits<double>::infinity());
  EXPECT_EQ(budget.needed(), 0U);
  budget.note_rate(1e300);
  budget.note_session(false, 1e300);
  EXPECT_GT(budget.needed(), std::uint64_t{1} << 50U);
}

TEST(SizeText, HasOneDecimal) {
  EXPECT_EQ(size_text(17), "17 B");
  EXPECT_EQ(size_text(3140), "3.1 kB");
  EXPECT_EQ(size_text(20'000'000), "20.0 MB");
  EXPECT_EQ(size_text(1'500'000'000), "1.5 GB");
}

}  // namespace
}  // namespace tonus::archive
