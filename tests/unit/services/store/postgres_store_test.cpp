#include "services/store/postgres_store.hpp"

#include <pqxx/pqxx>

#include "services/store/copy.hpp"
#include "services/store/memory_store.hpp"
#include "services/store/open_store.hpp"
#include "tests/support/postgres/postgres_server.hpp"
#include "tests/unit/services/store/store_contract.hpp"

/// On a real server, which this program starts once.
namespace tonus::store::testing {
namespace {

using tonus::testing::PostgresServer;

Result<PostgresServer*> server() {
  static const auto kServer = PostgresServer::start();
  if (!kServer) return kServer.error();
  return kServer->get();
}

Result<std::string> new_database() {
  const auto running = server();
  if (!running) return running.error();
  return (*running)->make_database();
}

Result<std::unique_ptr<Store>> postgres(const tonus::testing::TemporaryFolder&) {
  const auto url = new_database();
  if (!url) return url.error();
  return open_store_for_writing(*url);
}

INSTANTIATE_TEST_SUITE_P(Postgres, StoreContract, ::testing::Values(StoreMaker{"postgres", postgres}),
                         [](const auto& made) { return made.param.name; });

class PostgresStoreTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto url = new_database();
    if (!url && url.error().code == ErrorCode::kNotFound) GTEST_SKIP() << url.error().message;
    ASSERT_TRUE(url) << url.error().message;
    url_ = *url;
  }

  static std::string refusal(const Result<std::unique_ptr<Store>>& store) {
    return store ? "nothing refused" : store.error().message;
  }
  [[nodiscard]] std::string named(const std::string& rest) const { return "store '" + url_ + "': " + rest; }
  void run(const std::string& sql) const {
    pqxx::connection connection(url_);
    pqxx::work work(connection);
    work.exec(sql);
    work.commit();
  }

  std::string url_;
};

TEST_F(PostgresStoreTest, GivesBackWhatWasCopiedIntoIt) {
  MemoryStore from;
  Batch batch;
  batch.sessions.push_back(session_of(kSession, "2026-01-01T00:00:00Z"));
  StreamRecord stream{kStream, 0, {}, 0, 0};
  stream.coverage.add({0, 10});
  batch.streams.push_back(stream);
  batch.blocks.push_back(block_of(0, 10));
  for (const char* text : {"first", "second"})
    batch.messages.push_back(message_of("rig/command", id_of("key"), text));
  ASSERT_TRUE(from.commit(batch));
  {
    const auto server_side = open_store_for_writing(url_);
    ASSERT_TRUE(server_side) << server_side.error().message;
    ASSERT_TRUE(copy_store(from, **server_side, {}, {}));
  }
  MemoryStore back;
  const auto count = copy_store(**open_store_for_reading(url_), back, {}, {});
  ASSERT_TRUE(count) << count.error().message;
  EXPECT_EQ(count->messages, 2U);
  EXPECT_EQ(count->samples, 10U);
  EXPECT_EQ((*back.streams())[0].coverage, stream.coverage);
}

TEST_F(PostgresStoreTest, HasEverythingAfterItWasClosed) {
  Batch batch;
  batch.sessions = {session_of(kSession, "2026-03-01T10:00:00Z")};
  {
    const auto store = open_store_for_writing(url_);
    ASSERT_TRUE(store) << store.error().message;
    ASSERT_TRUE((*store)->commit(batch));
  }
  const auto store = open_store_for_writing(url_);
  ASSERT_TRUE(store) << store.error().message;
  EXPECT_EQ((*store)->sessions()->size(), 1U);
}

TEST_F(PostgresStoreTest, LetsOneArchiveWriteAtATimeAndOthersRead) {
  const auto writer = open_store_for_writing(url_);
  ASSERT_TRUE(writer);
  EXPECT_EQ(refusal(open_store_for_writing(url_)),
            named("is in use: another archive writes it, and one may at a time"));
  const auto reader = open_store_for_reading(url_);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_FALSE((*reader)->commit({}));
}

TEST_F(PostgresStoreTest, NamesADatabaseThatIsNotThere) {
  const std::string message = refusal(open_store_for_writing("postgresql://tonus:secret@127.0.0.1:9/none"));
  EXPECT_NE(message.find("store 'postgresql://tonus:***@127.0.0.1:9/none': its server cannot be reached"),
            std::string::npos)
      << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST_F(PostgresStoreTest, DoesNotMakeTablesToReadFrom) {
  EXPECT_EQ(refusal(open_store_for_reading(url_)), named("no archive of tonus is in this database"));
}

TEST_F(PostgresStoreTest, LeavesOtherTablesOfTheDatabaseAlone) {
  run("CREATE TABLE sessions (x INTEGER); INSERT INTO sessions VALUES (7)");
  const auto store = open_store_for_writing(url_);
  ASSERT_TRUE(store) << store.error().message;
  EXPECT_TRUE((*store)->sessions()->empty());
  pqxx::connection connection(url_);
  EXPECT_EQ(pqxx::work(connection).exec1("SELECT x FROM public.sessions")[0].as<int>(), 7);
}

TEST_F(PostgresStoreTest, RefusesANewerSchema) {
  ASSERT_TRUE(open_store_for_writing(url_));
  run("INSERT INTO tonus.schema_migrations VALUES (900, 'from the future', 0)");
  EXPECT_EQ(refusal(open_store_for_writing(url_)),
            named("schema version 900 is not allowed; expected 1 to 2; a newer program wrote it"));
}

TEST_F(PostgresStoreTest, BringsOlderTablesUpToDate) {
  ASSERT_TRUE(open_store_for_writing(url_));
  run("DROP TABLE tonus.session_certificates; DELETE FROM tonus.schema_migrations WHERE version = 2");
  EXPECT_EQ(refusal(open_store_for_reading(url_)),
            named("schema version 1 is not allowed; expected 2; tonus-archive migrates it"));
  const auto store = open_store_for_writing(url_);
  ASSERT_TRUE(store) << store.error().message;
  EXPECT_TRUE((*store)->session_certificates()->empty());
}

TEST_F(PostgresStoreTest, GoesOnAfterItsServerWasKilled) {
  const auto store = open_store_for_writing(url_);
  ASSERT_TRUE(store);
  Batch batch;
  batch.sessions = {session_of(kSession, "2026-03-01T10:00:00Z")};
  ASSERT_TRUE((*store)->commit(batch));
  (*server())->kill();
  batch.sessions = {session_of(id_of("next"), "2026-03-02T10:00:00Z")};
  for (int i = 0; i < 2; ++i) {
    const auto refused = (*store)->commit(batch);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kIo) << refused.error().message;
  }
  const auto restarted = (*server())->restart();
  ASSERT_TRUE(restarted) << restarted.error().message;
  const auto committed = (*store)->commit(batch);
  ASSERT_TRUE(committed) << committed.error().message;
  EXPECT_EQ((*store)->sessions()->size(), 2U);
}

}  // namespace
}  // namespace tonus::store::testing
