#include "services/store/sqlite_store.hpp"

#include <csignal>
#include <filesystem>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/store/made_up.hpp"

/// What a store on a disk has to bear.
namespace tonus::store {
namespace {

using testing::block_of;
using testing::kStream;

class SqliteStoreTest : public ::testing::Test {
 protected:
  static Batch batch_of(std::uint64_t first, std::uint32_t blocks) {
    Batch batch;
    Coverage coverage;
    for (std::uint32_t i = 0; i < blocks; ++i) batch.blocks.push_back(block_of(first + 20 * i, 20));
    coverage.add({0, first + 20 * blocks});
    batch.streams = {{kStream, 0, coverage, 0, 0}};
    return batch;
  }

  static std::size_t count_blocks(Store& store) {
    std::size_t count = 0;
    const auto visited =
        store.visit_blocks({kStream, {0, 1'000'000}}, [&count](const Block&) -> Result<void> {
          ++count;
          return {};
        });
    EXPECT_TRUE(visited);
    return count;
  }

  tonus::testing::TemporaryFolder folder_;
  std::string path_ = folder_ / "study.sqlite";
};

TEST_F(SqliteStoreTest, HasEverythingAfterItWasClosed) {
  {
    const auto store = SqliteStore::open(path_, SqliteStore::Access::kWrite);
    ASSERT_TRUE(store);
    ASSERT_TRUE((*store)->commit(batch_of(0, 3)));
  }
  const auto store = SqliteStore::open(path_, SqliteStore::Access::kWrite);
  ASSERT_TRUE(store);
  ASSERT_TRUE((*store)->commit(batch_of(60, 2)));
  EXPECT_EQ(count_blocks(**store), 5U);
  EXPECT_EQ((*store)->streams()->front().coverage.ranges(), (std::vector<SequenceRange>{{0, 100}}));
}

TEST_F(SqliteStoreTest, TakesABatchWholeOrNotAtAll) {
  const auto store = SqliteStore::open(path_, SqliteStore::Access::kWrite);
  ASSERT_TRUE(store);
  Batch batch = batch_of(0, 3);
  batch.blocks.push_back(
      block_of(60, 20, kNoId, false, {id_of("unknown rig"), 1}));  // its stream is in no batch
  EXPECT_FALSE((*store)->commit(batch));
  EXPECT_EQ(count_blocks(**store), 0U);
  EXPECT_TRUE((*store)->streams()->empty());
  batch.blocks.pop_back();
  ASSERT_TRUE((*store)->commit(batch));
  EXPECT_EQ(count_blocks(**store), 3U);
}

TEST_F(SqliteStoreTest, SaysThatItsFileWasRemoved) {
  const auto store = SqliteStore::open(path_, SqliteStore::Access::kWrite);
  ASSERT_TRUE(store);
  ASSERT_TRUE((*store)->commit(batch_of(0, 1)));
  std::filesystem::remove(path_);
  const auto committed = (*store)->commit(batch_of(20, 1));
  ASSERT_FALSE(committed);
  EXPECT_EQ(committed.error().code, ErrorCode::kIo);
  EXPECT_EQ(
      committed.error().message,
      "store '" + path_ + "': was removed or replaced while it is in use: what is written would be lost");
}

/// Limits the size of files in a child, so that the disk refuses a commit, and lifts it again.
TEST_F(SqliteStoreTest, GoesOnAfterADiskThatWasFull) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    auto store = SqliteStore::open(path_, SqliteStore::Access::kWrite);
    if (!store || !(*store)->commit(batch_of(0, 1))) ::_exit(2);
    rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    const rlimit full{200'000, limit.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &full);
    std::uint64_t next = 20;
    int refused = 0;
    for (int i = 0; i < 40 && refused == 0; ++i) {
      const auto committed = (*store)->commit(batch_of(next, 50));
      if (committed) {
        next += 1000;
      } else {
        refused = committed.error().code == ErrorCode::kIo ? 1 : 100;
      }
    }
    if (refused != 1) ::_exit(3);
    if ((*store)->commit(batch_of(next, 50))) ::_exit(4);
    ::setrlimit(RLIMIT_FSIZE, &limit);
    if (!(*store)->commit(batch_of(next, 50))) ::_exit(5);
    if (count_blocks(**store) != (next + 1000) / 20) ::_exit(6);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace tonus::store
