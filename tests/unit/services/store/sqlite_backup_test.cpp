#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>

#include "services/store/session_reader.hpp"
#include "services/store/sqlite_store.hpp"
#include "services/verification/verification.hpp"
#include "tests/support/made_up_session/made_up_session.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/store/made_up.hpp"

namespace tonus::store {
namespace {

using ::testing::HasSubstr;

class SqliteBackup : public ::testing::Test {
 protected:
  void SetUp() override {
    auto writer = SqliteStore::open(file(), SqliteStore::Access::kWrite);
    ASSERT_TRUE(writer) << writer.error().message;
    writer_ = std::move(*writer);
    record_ = made_up::put_session(*writer_, made_up::unloaded_session());
  }

  std::string file() const { return (folder_ / "archive.sqlite").string(); }
  std::string target() const { return (folder_ / "backup.sqlite").string(); }

  Result<void> back_up(const std::function<void(std::uint64_t, std::uint64_t)>& progress = {}) {
    TONUS_TRY_ASSIGN(const auto reader, SqliteStore::open(file(), SqliteStore::Access::kRead));
    return reader->copy_to(target(), progress);
  }

  void commit_message(const std::string& text) {
    Batch batch;
    batch.messages.push_back(testing::message_of("rig/command", id_of("key"), text));
    const auto committed = writer_->commit(batch);
    EXPECT_TRUE(committed) << committed.error().message;
  }

  static std::size_t commands_in(Store& store) {
    std::size_t count = 0;
    EXPECT_TRUE(store.visit_messages({"rig/command", {}, {}}, [&](const Message&) {
      ++count;
      return Result<void>();
    }));
    return count;
  }

  tonus::testing::TemporaryFolder folder_;
  std::unique_ptr<SqliteStore> writer_;
  SessionRecord record_;
};

TEST_F(SqliteBackup, WhileItIsWrittenHoldsEverythingCommittedBeforeAndVerifiesWell) {
  commit_message("before");
  int commits_meanwhile = 0;
  const auto made = back_up([&](std::uint64_t done, std::uint64_t total) {
    EXPECT_LE(done, total);
    commit_message("meanwhile");  // waits for nothing
    ++commits_meanwhile;
  });
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_GE(commits_meanwhile, 1);
  const auto backup = SqliteStore::open(target(), SqliteStore::Access::kRead);
  ASSERT_TRUE(backup) << backup.error().message;
  EXPECT_EQ(commands_in(**backup), 1U) << "a moment, not a mixture";
  const auto verified = verification::verify_session(**backup, record_, {});
  ASSERT_TRUE(verified) << verified.error().message;
  EXPECT_TRUE(verified->is_well()) << ::testing::PrintToString(verified->problems);
}

TEST_F(SqliteBackup, RestsInOneFileThatIsReadWithoutTheRightToWrite) {
  ASSERT_TRUE(back_up());
  for (const char* suffix : {"-wal", "-shm", ".partial", "-journal"})
    EXPECT_FALSE(std::filesystem::exists(target() + suffix)) << suffix;
  std::filesystem::permissions(target(), std::filesystem::perms::owner_read);
  const auto backup = SqliteStore::open(target(), SqliteStore::Access::kRead);
  ASSERT_TRUE(backup) << backup.error().message;
  EXPECT_EQ((*backup)->sessions()->size(), 1U);
}

TEST_F(SqliteBackup, IsWrittenOnAsAnArchive) {
  ASSERT_TRUE(back_up());
  auto restored = SqliteStore::open(target(), SqliteStore::Access::kWrite);
  ASSERT_TRUE(restored) << restored.error().message;
  Batch batch;
  batch.messages.push_back(testing::message_of("rig/command", id_of("key"), "after"));
  EXPECT_TRUE((*restored)->commit(batch));
  EXPECT_EQ(commands_in(**restored), 1U);
}

TEST_F(SqliteBackup, NeverTakesThePlaceOfAFile) {
  std::ofstream(target()) << "dear";
  const auto made = back_up();
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("already exists"));
  EXPECT_EQ(std::filesystem::file_size(target()), 4U);
  std::filesystem::remove(target());
  std::ofstream(target() + "-wal") << "of a file that is gone";
  EXPECT_FALSE(back_up());
  EXPECT_FALSE(std::filesystem::exists(target()));
}

TEST_F(SqliteBackup, LeavesNothingBehindWhereItFails) {
  const auto reader = SqliteStore::open(file(), SqliteStore::Access::kRead);
  ASSERT_TRUE(reader);
  EXPECT_FALSE((*reader)->copy_to((folder_ / "none" / "backup.sqlite").string(), {}));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none"));
  EXPECT_TRUE((*reader)->copy_to(target(), {})) << "the store is still of use";
}

}  // namespace
}  // namespace tonus::store
