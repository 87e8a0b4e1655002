#include "services/store/copy.hpp"

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include "services/store/memory_store.hpp"
#include "services/store/session_reader.hpp"
#include "services/store/sqlite_store.hpp"
#include "services/verification/verification.hpp"
#include "tests/support/made_up_session/made_up_session.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/store/made_up.hpp"

namespace tonus::store {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

const Id kOld = id_of("old session");
const Id kNew = id_of("new session");

/// A session of one trial of 10 samples; the rig was described in the first one.
void put_small_session(Store& store, const Id& id, std::uint64_t first, const std::string& started_at) {
  using namespace testing;
  Batch batch;
  batch.sessions.push_back(session_of(id, started_at));
  StreamRecord stream{kStream, 0, {}, 1, 2};
  stream.coverage.add({0, first + 10});
  batch.streams.push_back(stream);
  TrialRecord trial = trial_of(1, first, first + 9);
  trial.session = id;
  trial.trial = trial_id(id, 1);
  trial.is_certified = true;
  trial.certificate.expected = trial.certificate.received = 10;
  batch.trials.push_back(trial);
  Block block = block_of(first, 10, trial.trial);
  block.session = id;
  batch.blocks.push_back(block);
  const auto say = [&](const char* topic, const Id& key, const std::string& text) {
    Message message = message_of(topic, key, text);
    message.session = id;
    message.received_ns = first;
    batch.messages.push_back(message);
  };
  if (id == kOld) say("rig/description", kRig, "described once");
  say("session/plan", id, "plan of " + started_at);
  SessionCertificate certificate;
  certificate.session = id;
  certificate.certified_ns = first;
  certificate.add(trial);
  batch.certificates.push_back(certificate);
  ASSERT_TRUE(store.commit(batch));
}

std::vector<std::string> texts_in(Store& store) {
  std::vector<std::string> texts;
  EXPECT_TRUE(store.visit_messages({}, [&texts](const Message& message) {
    const auto* begin = reinterpret_cast<const char*>(message.payload->data());
    texts.emplace_back(begin, message.payload->size());
    return Result<void>();
  }));
  return texts;
}

std::vector<std::uint64_t> firsts_in(Store& store) {
  std::vector<std::uint64_t> firsts;
  EXPECT_TRUE(store.visit_blocks({testing::kStream, {0, kLargestSequence}}, [&firsts](const Block& block) {
    firsts.push_back(block.first_sequence);
    return Result<void>();
  }));
  return firsts;
}

class Copying : public ::testing::Test {
 protected:
  void SetUp() override {
    auto store = SqliteStore::open(file(), SqliteStore::Access::kWrite);
    ASSERT_TRUE(store) << store.error().message;
    put_small_session(**store, kOld, 100, "2026-01-01T00:00:00Z");
    put_small_session(**store, kNew, 200, "2026-02-01T00:00:00Z");
  }

  std::string file() const { return (folder_ / "archive.sqlite").string(); }
  std::string target() const { return (folder_ / "copy.sqlite").string(); }
  static std::unique_ptr<SqliteStore> open(const std::string& path) {
    auto store = SqliteStore::open(path, SqliteStore::Access::kRead);
    EXPECT_TRUE(store) << store.error().message;
    return store ? std::move(*store) : nullptr;
  }

  tonus::testing::TemporaryFolder folder_;
};

TEST_F(Copying, TakesEverythingInTheOrderInWhichItCame) {
  MemoryStore to;
  const auto count = copy_store(*open(file()), to, {}, {});
  ASSERT_TRUE(count) << count.error().message;
  EXPECT_EQ(count->sessions, 2U);
  EXPECT_EQ(count->samples, 20U);
  EXPECT_THAT(texts_in(to),
              ElementsAre("described once", "plan of 2026-01-01T00:00:00Z", "plan of 2026-02-01T00:00:00Z"));
  EXPECT_THAT(firsts_in(to), ElementsAre(100U, 200U));
  EXPECT_EQ(to.trials(kNew)->front().certificate.received, 10U);
  EXPECT_EQ(to.session_certificates()->size(), 2U);
  const auto streams = *to.streams();
  ASSERT_EQ(streams.size(), 1U);
  EXPECT_EQ(streams[0].coverage.count_in({0, 1000}), 210U);
  EXPECT_EQ(streams[0].resent, 1U);
}

TEST_F(Copying, OfOneSessionTakesWhatWasInForceAndClaimsNoSampleOfAnother) {
  MemoryStore to;
  ASSERT_TRUE(copy_store(*open(file()), to, {{kNew}, {}}, {}));
  EXPECT_THAT(texts_in(to), ElementsAre("described once", "plan of 2026-02-01T00:00:00Z"));
  EXPECT_THAT(firsts_in(to), ElementsAre(200U));
  EXPECT_EQ(to.sessions()->size(), 1U);
  EXPECT_EQ((*to.streams())[0].coverage.count_in({0, 1000}), 10U);
}

TEST_F(Copying, IntoAStoreThatHoldsSomethingIsRefused) {
  MemoryStore to;
  put_small_session(to, kOld, 100, "2026-01-01T00:00:00Z");
  const auto count = copy_store(*open(file()), to, {}, {});
  ASSERT_FALSE(count);
  EXPECT_THAT(count.error().message, HasSubstr("holds 1 sessions; expected an empty one"));
}

TEST_F(Copying, StopsAtADamagedPayloadAndLeavesNoFile) {
  Batch batch;
  Message damaged = testing::message_of("rig/command", id_of("key"), "text");
  damaged.checksum ^= 1U;
  batch.messages.push_back(damaged);
  ASSERT_TRUE((*SqliteStore::open(file(), SqliteStore::Access::kWrite))->commit(batch));
  const auto count = copy_to_sqlite(*open(file()), target(), {}, {});
  ASSERT_FALSE(count);
  EXPECT_EQ(count.error().code, ErrorCode::kDataLoss);
  for (const char* suffix : {"", ".partial", ".partial-wal", ".partial-lock"})
    EXPECT_FALSE(std::filesystem::exists(target() + suffix)) << suffix;
}

TEST_F(Copying, NeverTakesThePlaceOfAFile) {
  std::ofstream(target()) << "dear";
  EXPECT_FALSE(copy_to_sqlite(*open(file()), target(), {}, {}));
  EXPECT_EQ(std::filesystem::file_size(target()), 4U);
  std::filesystem::remove(target());
  std::ofstream(target() + "-wal") << "of a file that is gone";
  EXPECT_FALSE(copy_to_sqlite(*open(file()), target(), {}, {}));
  EXPECT_FALSE(std::filesystem::exists(target()));
}

TEST_F(Copying, OfAWholeSessionVerifiesAsTheSessionItself) {
  MemoryStore from;
  const auto record = made_up::put_session(from, made_up::unloaded_session());
  ASSERT_TRUE(copy_to_sqlite(from, target(), {{record.session}, {}}, {}));
  const auto verified = verification::verify_session(*open(target()), record, {});
  ASSERT_TRUE(verified) << verified.error().message;
  EXPECT_TRUE(verified->is_well()) << ::testing::PrintToString(verified->problems);
}

using Pruning = Copying;

TEST_F(Pruning, RemovesTheSessionForGoodAndKeepsWhatTheOthersNeed) {
  std::filesystem::permissions(file(),
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  const auto size = std::filesystem::file_size(file());
  const auto count = prune_sqlite(file(), {kOld}, {});
  ASSERT_TRUE(count) << count.error().message;
  const auto store = open(file());
  EXPECT_THAT(texts_in(*store), UnorderedElementsAre("described once", "plan of 2026-02-01T00:00:00Z"));
  EXPECT_THAT(firsts_in(*store), ElementsAre(200U));
  EXPECT_TRUE(store->trials(kOld)->empty());
  EXPECT_EQ((*store->streams())[0].coverage.count_in({0, 1000}), 210U) << "the rig is not asked for it again";
  EXPECT_LE(std::filesystem::file_size(file()), size);
  EXPECT_EQ(std::filesystem::status(file()).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  for (const char* suffix : {"-wal", "-shm", "-lock", ".pruned", ".pruned.partial"})
    EXPECT_FALSE(std::filesystem::exists(file() + suffix)) << suffix;
}

TEST_F(Pruning, ByTheSuperuserLeavesTheFileToItsOwner) {
  if (::geteuid() != 0) GTEST_SKIP() << "only the superuser may give a file away";
  constexpr uid_t kOther = 12345;
  ASSERT_EQ(::chown(file().c_str(), kOther, kOther), 0);
  const auto count = prune_sqlite(file(), {kOld}, {});
  ASSERT_TRUE(count) << count.error().message;
  struct stat status {};
  ASSERT_EQ(::stat(file().c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, kOther);
  EXPECT_EQ(status.st_gid, kOther);
}

TEST_F(Pruning, OfAnArchiveThatIsWrittenChangesNothing) {
  const auto writer = SqliteStore::open(file(), SqliteStore::Access::kWrite);
  ASSERT_TRUE(writer);
  const auto count = prune_sqlite(file(), {kOld}, {});
  ASSERT_FALSE(count);
  EXPECT_THAT(count.error().message, HasSubstr("in use"));
  EXPECT_EQ((*writer)->sessions()->size(), 2U);
}

}  // namespace
}  // namespace tonus::store
