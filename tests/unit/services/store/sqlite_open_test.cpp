#include <fstream>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "services/store/open_store.hpp"
#include "services/store/sqlite.hpp"
#include "services/store/sqlite_schema.hpp"
#include "services/store/sqlite_store.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/store/made_up.hpp"

namespace tonus::store {
namespace {

namespace fs = std::filesystem;

class SqliteOpen : public ::testing::Test {
 protected:
  static std::string refusal(const Result<std::unique_ptr<SqliteStore>>& store) {
    return store ? "nothing refused" : store.error().message;
  }
  [[nodiscard]] std::string write_refusal() const {
    return refusal(SqliteStore::open(path_, SqliteStore::Access::kWrite));
  }
  [[nodiscard]] std::string read_refusal() const {
    return refusal(SqliteStore::open(path_, SqliteStore::Access::kRead));
  }
  [[nodiscard]] std::string named(const std::string& rest) const { return "store '" + path_ + "': " + rest; }

  /// Runs SQL on the file with a connection of its own.
  void run(const std::string& sql) const {
    auto database = Database::open(path_, Database::Mode::kReadWrite);
    ASSERT_TRUE(database);
    const auto done = database->run(sql.c_str());
    ASSERT_TRUE(done) << done.error().message;
  }

  tonus::testing::TemporaryFolder folder_;
  std::string path_ = folder_ / "study.sqlite";
};

TEST_F(SqliteOpen, MakesAFileThatSaysWhatItIs) {
  { ASSERT_EQ(write_refusal(), "nothing refused"); }
  auto database = Database::open(path_, Database::Mode::kReadOnly);
  ASSERT_TRUE(database);
  EXPECT_EQ(*database->number("PRAGMA application_id"), 0x746F6E75);
  EXPECT_EQ(*database->number("SELECT max(version) FROM schema_migrations"), newest_schema_version());
  EXPECT_EQ(*database->text("PRAGMA journal_mode"), "wal");
}

TEST_F(SqliteOpen, LeavesNothingBesideTheFileAfterAnOrderlyEnd) {
  { ASSERT_TRUE(SqliteStore::open(path_, SqliteStore::Access::kWrite)); }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1);
}

TEST_F(SqliteOpen, NamesAFolderThatIsMissing) {
  path_ = folder_ / "no" / "study.sqlite";
  EXPECT_EQ(write_refusal(), named("its folder '" + (folder_ / "no").string() + "' does not exist"));
}

TEST_F(SqliteOpen, NamesAFolderInPlaceOfAFile) {
  fs::create_directory(path_);
  EXPECT_EQ(write_refusal(), named("is a folder; expected a file"));
}

TEST_F(SqliteOpen, TellsALinkThatLeadsNowhereOrInCirclesFromAFileThatIsNotThere) {
  std::filesystem::create_symlink("circle", folder_ / "circle");
  std::filesystem::create_symlink("missing", folder_ / "dangling");
  for (const char* name : {"circle", "dangling"}) {
    const auto store = open_store_for_reading((folder_ / name).string());
    ASSERT_FALSE(store) << name;
    EXPECT_EQ(store.error().code, ErrorCode::kIo) << name;
    EXPECT_NE(store.error().message.find(std::string(name) + ": cannot be reached"), std::string::npos)
        << store.error().message;
  }
}

TEST_F(SqliteOpen, DoesNotMakeAFileToReadFrom) {
  EXPECT_EQ(read_refusal(), named("no such file"));
  EXPECT_FALSE(fs::exists(path_));
}

TEST_F(SqliteOpen, RefusesAFileThatIsNotSqlite) {
  std::ofstream(path_) << std::string(5000, 'x');
  EXPECT_EQ(write_refusal(), named("is not an archive of tonus: it is not an SQLite file"));
  EXPECT_EQ(read_refusal(), named("is not an archive of tonus: it is not an SQLite file"));
  EXPECT_EQ(fs::file_size(path_), 5000U);
}

TEST_F(SqliteOpen, RefusesAnotherProgramsFileAndLeavesItAlone) {
  run("CREATE TABLE theirs (x)");
  EXPECT_EQ(write_refusal(),
            named("is not an archive of tonus: its application_id is 0x0; expected 0x746f6e75"));
  auto database = Database::open(path_, Database::Mode::kReadOnly);
  EXPECT_EQ(*database->text("PRAGMA journal_mode"), "delete");
  EXPECT_EQ(*database->number("SELECT count(*) FROM sqlite_master"), 1);
}

TEST_F(SqliteOpen, RefusesANewerSchema) {
  { ASSERT_TRUE(SqliteStore::open(path_, SqliteStore::Access::kWrite)); }
  run("INSERT INTO schema_migrations VALUES (900, 'from the future', 0)");
  const std::string expected =
      named("schema version 900 is not allowed; expected 1 to " + std::to_string(newest_schema_version()) +
            "; a newer program wrote the file");
  EXPECT_EQ(write_refusal(), expected);
  EXPECT_EQ(read_refusal(), expected);
}

TEST_F(SqliteOpen, BringsAnArchiveFromBeforeAuxiliaryChannelsUpToDateWithItsBlocks) {
  {
    const auto store = SqliteStore::open(path_, SqliteStore::Access::kWrite);
    ASSERT_TRUE(store);
    Batch batch;
    StreamRecord stream{store::testing::kStream, 0, {}, 0, 0};
    stream.coverage.add({0, 20});
    batch.streams = {stream};
    batch.blocks = {store::testing::block_of(0, 20)};
    ASSERT_TRUE((*store)->commit(batch));
  }
  run("ALTER TABLE blocks DROP COLUMN is_auxiliary; ALTER TABLE streams DROP COLUMN auxiliary_values; "
      "DROP TABLE auxiliary_coverage; DELETE FROM schema_migrations WHERE version = 3");
  const auto pending = SqliteStore::pending_upgrade(path_);
  ASSERT_TRUE(pending) << pending.error().message;
  EXPECT_EQ(*pending, (std::vector<std::string>{"3: auxiliary channels"}));
  const auto store = SqliteStore::open(path_, SqliteStore::Access::kWrite);
  ASSERT_TRUE(store) << store.error().message;
  int blocks = 0;
  EXPECT_TRUE(
      (*store)->visit_blocks({store::testing::kStream, {0, 20}}, [&](const Block& block) -> Result<void> {
        ++blocks;
        EXPECT_EQ(*block.payload, *store::testing::block_of(0, 20).payload);
        return {};
      }));
  EXPECT_EQ(blocks, 1);
  EXPECT_EQ((*store)->streams()->at(0).auxiliary_values, 0U);
}

TEST_F(SqliteOpen, LetsOneArchiveWriteAtATimeAndOthersRead) {
  const auto writer = SqliteStore::open(path_, SqliteStore::Access::kWrite);
  ASSERT_TRUE(writer);
  EXPECT_EQ(write_refusal(), named("is in use: another archive writes it, and one may at a time"));
  EXPECT_EQ(read_refusal(), "nothing refused");
  Batch batch;
  batch.sessions = {{}};
  EXPECT_TRUE((*writer)->commit(batch));
  auto reader = SqliteStore::open(path_, SqliteStore::Access::kRead);
  ASSERT_TRUE(reader);
  EXPECT_EQ((*reader)->sessions()->size(), 1U);
  EXPECT_FALSE((*reader)->commit(batch));
}

/// What `look` says in a child that is not root: whoever may do anything is not refused.
template <typename Look>
std::string as_somebody_else(const Look& look) {
  int ends[2];
  if (::pipe(ends) != 0) return "no pipe";
  const pid_t child = ::fork();
  if (child == 0) {
    if (::geteuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0)) ::_exit(2);
    const std::string message = look();
    ::_exit(::write(ends[1], message.data(), message.size()) == static_cast<ssize_t>(message.size()) ? 0 : 3);
  }
  ::close(ends[1]);
  std::string message(1000, '\0');
  message.resize(
      static_cast<std::size_t>(std::max<ssize_t>(0, ::read(ends[0], message.data(), message.size()))));
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  return status == 0 ? message : "the child failed";
}

TEST_F(SqliteOpen, NamesAFileThatMayNotBeWritten) {
  { ASSERT_TRUE(SqliteStore::open(path_, SqliteStore::Access::kWrite)); }
  ::chmod(path_.c_str(), 0444);
  ::chmod(folder_.path().c_str(), 0777);  // the lock file may be made, the store not be written
  EXPECT_EQ(as_somebody_else([this] { return write_refusal(); }),
            named("is read-only; expected a writable file"));
}

TEST_F(SqliteOpen, ReadsARestingArchiveWithoutTheRightToWriteAndChangesNothing) {
  Batch batch;
  batch.sessions = {{}};
  { ASSERT_TRUE((*SqliteStore::open(path_, SqliteStore::Access::kWrite))->commit(batch)); }
  ::chmod(path_.c_str(), 0444);
  ::chmod(folder_.path().c_str(), 0555);
  const auto before = fs::last_write_time(folder_.path());
  const auto look = [this]() -> std::string {
    auto store = SqliteStore::open(path_, SqliteStore::Access::kRead);
    if (!store) return store.error().message;
    const auto sessions = (*store)->sessions();
    return sessions ? std::to_string(sessions->size()) : sessions.error().message;
  };
  EXPECT_EQ(as_somebody_else(look), "1");
  EXPECT_EQ(look(), "1");
  EXPECT_EQ(fs::last_write_time(folder_.path()), before) << "nothing was made beside the file";
  ::chmod(folder_.path().c_str(), 0755);
}

TEST_F(SqliteOpen, ReadsARestingArchiveOfAnyName) {
  path_ = folder_ / "50 % #1?mode=rw.sqlite";
  { ASSERT_TRUE(SqliteStore::open(path_, SqliteStore::Access::kWrite)); }
  EXPECT_EQ(read_refusal(), "nothing refused");
}

TEST_F(SqliteOpen, LeavesTheLogOfACrashedArchiveToItsOwner) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs another user";
  const std::string copy = folder_ / "copy.sqlite";
  {
    const auto store = SqliteStore::open(path_, SqliteStore::Access::kWrite);
    Batch batch;
    batch.sessions = {{}};
    ASSERT_TRUE((*store)->commit(batch));
    for (const char* suffix : {"", "-wal"}) fs::copy_file(path_ + suffix, copy + suffix);
  }
  path_ = copy;  // as a crash leaves it
  ::chmod(folder_.path().c_str(), 0777);
  for (const char* suffix : {"", "-wal"}) ::chmod((path_ + suffix).c_str(), 0666);
  const std::string refusal = as_somebody_else([this] { return read_refusal(); });
  EXPECT_NE(refusal.find("was not closed in an orderly way"), std::string::npos) << refusal;
  EXPECT_FALSE(fs::exists(path_ + "-shm"));
  EXPECT_EQ((*SqliteStore::open(path_, SqliteStore::Access::kRead))->sessions()->size(), 1U);
}

TEST_F(SqliteOpen, RefusesAFileThatWasCopiedWithoutItsLog) {
  const std::string copy = folder_ / "copy.sqlite";
  {
    const auto store = SqliteStore::open(path_, SqliteStore::Access::kWrite);
    Batch batch;
    batch.sessions = {{}};
    ASSERT_TRUE((*store)->commit(batch));
    fs::copy_file(path_, copy);
  }
  EXPECT_EQ(read_refusal(), "nothing refused");
  path_ = copy;
  const std::string expected = named(
      "was copied or moved while it was written, without its log: the newest data are missing; expected '" +
      path_ + "-wal' beside it (`tonus recover` copies what is here)");
  EXPECT_EQ(read_refusal(), expected);
  EXPECT_EQ(write_refusal(), expected);
}

TEST_F(SqliteOpen, RefusesAFileWithoutATableInsteadOfMakingAnEmptyArchiveOfIt) {
  run("PRAGMA journal_mode = WAL");  // what an older version left in the file until its first checkpoint
  ASSERT_GT(fs::file_size(path_), 0U);
  EXPECT_NE(write_refusal().find("holds no table"), std::string::npos) << write_refusal();
  EXPECT_NE(read_refusal().find("holds no table"), std::string::npos) << read_refusal();
}

TEST_F(SqliteOpen, NamesTheRemedyForATruncatedFile) {
  { ASSERT_TRUE(SqliteStore::open(path_, SqliteStore::Access::kWrite)); }
  const auto whole = fs::file_size(path_);
  fs::resize_file(path_, whole - 5000);
  const std::string expected = named("is cut off: has " + std::to_string(whole - 5000) + " of " +
                                     std::to_string(whole) + " bytes; `tonus recover` copies what is left");
  EXPECT_EQ(read_refusal(), expected);
  EXPECT_EQ(write_refusal(), expected);
}

TEST_F(SqliteOpen, SaysThatAnArchiveBeganToBeWrittenWhileItWasRead) {
  { ASSERT_TRUE(SqliteStore::open(path_, SqliteStore::Access::kWrite)); }
  const auto reader = SqliteStore::open(path_, SqliteStore::Access::kRead);
  ASSERT_TRUE(reader);
  ASSERT_TRUE((*reader)->sessions());
  fs::last_write_time(path_, fs::last_write_time(path_) + std::chrono::seconds(1));  // what a commit does
  const auto sessions = (*reader)->sessions();
  ASSERT_FALSE(sessions);
  EXPECT_EQ(sessions.error().message, named("began to be written while it was read; read it again"));
}

TEST_F(SqliteOpen, TellsFilesFromMemoryByTheirName) {
  const auto memory = open_store_for_writing(":memory:");
  ASSERT_TRUE(memory);
  EXPECT_EQ((*memory)->name(), ":memory:");
  EXPECT_FALSE(fs::exists(":memory:"));
  const auto file = open_store_for_writing(path_);
  ASSERT_TRUE(file);
  EXPECT_EQ((*file)->name(), path_);
  const auto url = open_store_for_writing("mysql://host/study");
  ASSERT_FALSE(url);
  EXPECT_EQ(url.error().message,
            "store 'mysql://host/study': is not allowed; expected the path of a file, "
            "postgresql://... or :memory:");
}

}  // namespace
}  // namespace tonus::store
