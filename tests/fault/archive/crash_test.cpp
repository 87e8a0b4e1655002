#include <gtest/gtest.h>

#include "services/store/sqlite_store.hpp"
#include "tests/fault/archive/crash_campaign.hpp"
#include "tests/fault/archive/faulty_disk.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

/// Short slices of the crash campaign; the long one is `archive_crash_campaign`.
namespace tonus::archive::testing {
namespace {

void crash(CrashCampaign& campaign, int crashes) {
  for (int i = 0; i < crashes; ++i) {
    const auto good = campaign.crash();
    ASSERT_TRUE(good) << "crash " << i << ": " << good.error().message;
  }
  EXPECT_EQ(campaign.counts().crashes, static_cast<std::uint64_t>(crashes));
  EXPECT_GT(campaign.counts().receipts, static_cast<std::uint64_t>(crashes));
}

TEST(ArchiveCrash, DiskThatFailsLosesNothingThatAReceiptWasGivenFor) {
  const tonus::testing::TemporaryFolder folder;
  PowerLossCampaign campaign(folder.path(), 7);
  crash(campaign, 30);
}

TEST(ArchiveCrash, KilledProcessLosesNothingThatAReceiptWasGivenFor) {
  const tonus::testing::TemporaryFolder folder;
  KillCampaign campaign(folder.path(), 7, tonus::testing::program("tonus-archive"),
                        tonus::testing::own_domain());
  crash(campaign, 6);
}

/// The campaign would notice: a store that acknowledges before it syncs loses what it promised.
TEST(ArchiveCrash, FaultyDiskLosesWhatWasNotSynced) {
  const tonus::testing::TemporaryFolder folder;
  const std::string file = folder / "unsynced.sqlite";
  int lost = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    FaultyDisk disk(seed);
    {
      auto database = store::Database::open(file, store::Database::Mode::kReadWrite);
      ASSERT_TRUE(database);
      ASSERT_EQ(*database->text("PRAGMA journal_mode = WAL"), "wal");
      ASSERT_TRUE(
          database->run("PRAGMA synchronous = NORMAL; CREATE TABLE IF NOT EXISTS t (x); DELETE FROM t; "
                        "PRAGMA wal_checkpoint(TRUNCATE); INSERT INTO t VALUES (1)"));
      disk.fail_at(disk.operations() + 1, FaultyDisk::Failure::kPowerLoss);
    }
    disk.lose_power();
    auto database = store::Database::open(file, store::Database::Mode::kReadWrite);
    ASSERT_TRUE(database);
    const auto rows = database->number("SELECT count(*) FROM t");
    ASSERT_TRUE(rows) << rows.error().message;
    lost += *rows == 0 ? 1 : 0;
  }
  EXPECT_GT(lost, 5);
  EXPECT_LT(lost, 20);
}

TEST(ArchiveCrash, FaultyDiskRefusesTheChosenOperation) {
  const tonus::testing::TemporaryFolder folder;
  FaultyDisk disk(1);
  const auto store = store::SqliteStore::open(folder / "study.sqlite", store::SqliteStore::Access::kWrite);
  ASSERT_TRUE(store) << store.error().message;
  disk.fail_at(disk.operations() + 1, FaultyDisk::Failure::kError);
  store::Batch batch;
  batch.sessions = {store::SessionRecord{}};
  const auto refused = (*store)->commit(batch);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
  EXPECT_TRUE(disk.has_failed());
  EXPECT_FALSE(disk.is_off());
  EXPECT_TRUE((*store)->sessions()->empty());
  EXPECT_TRUE((*store)->commit(batch));
}

}  // namespace
}  // namespace tonus::archive::testing
