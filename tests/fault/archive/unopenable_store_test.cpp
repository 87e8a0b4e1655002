#include <csignal>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>

#include "idl/topics.hpp"
#include "services/core/clock.hpp"
#include "services/store/sqlite_store.hpp"
#include "tests/fault/archive/rig_end.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include <idl/service.h>

namespace tonus::archive::testing {
namespace {

using namespace std::chrono_literals;

/// tonus-archive with a store that cannot be opened, as others see it.
TEST(UnopenableStore, IsNamedInTheHealthAndTriedAgain) {
  const tonus::testing::TemporaryFolder folder;
  const auto away = folder / "disk";
  const int domain = tonus::testing::own_domain();
  tonus::testing::Process archive(
      tonus::testing::program("tonus-archive"),
      {"--store", (away / "study.sqlite").string(), "--domain", std::to_string(domain)}, folder / "log");
  const auto notifier = std::make_shared<bus::Notifier>();
  MadeUpRig rig(1);
  auto end = RigEnd::create(rig, domain, bus::Vendor::kFastDds, notifier);
  ASSERT_TRUE(end) << end.error().message;
  auto reader = bus::TypedReader<v1::ServiceHealth>::create(end->bus(), topics::kServiceHealth, notifier);
  ASSERT_TRUE(reader);
  v1::ServiceHealth health;
  const SystemClock clock;
  const auto eventually = [&](const auto& condition) {
    const auto deadline = clock.now() + 20s;
    while (!condition()) {
      if (clock.now() > deadline) return false;
      EXPECT_TRUE(end->answer());
      std::vector<bus::Received<v1::ServiceHealth>> reports;
      reader->take(reports);
      if (!reports.empty()) health = reports.back().value;
      static_cast<void>(notifier->wait_until(clock.now() + 10ms));
    }
    return true;
  };
  ASSERT_TRUE(eventually([&] {
    return health.state().find("study.sqlite': its folder") != std::string::npos;
  })) << health.state();
  EXPECT_FALSE(health.is_ready());
  EXPECT_EQ(rig.receipts(), 0U);

  std::filesystem::create_directory(away);
  ASSERT_TRUE(eventually([&] { return health.is_ready(); })) << health.state();
  ASSERT_TRUE(eventually([&] { return end->is_heard(); }));
  end->run_trial();
  EXPECT_TRUE(eventually([&] { return rig.trials_without_receipt().empty(); })) << archive.output();
  archive.signal(SIGTERM);
  EXPECT_EQ(archive.wait(10s), 0) << archive.output();
}

TEST(UnopenableStore, EndsTheProgramWhereItsNameIsNotAllowed) {
  const tonus::testing::TemporaryFolder folder;
  tonus::testing::Process archive(
      tonus::testing::program("tonus-archive"),
      {"--store", "mysql://ann:secret@host/study", "--domain", std::to_string(tonus::testing::own_domain())},
      folder / "log");
  EXPECT_EQ(archive.wait(20s), 1);
  EXPECT_EQ(archive.output(),
            "tonus-archive: store 'mysql://ann:***@host/study': is not allowed; expected the path of a file, "
            "postgresql://... or :memory:\n");
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(OlderStore, IsChangedOnlyWhereAPersonHasAllowedIt) {
  const tonus::testing::TemporaryFolder folder;
  const auto file = folder / "study.sqlite";
  ASSERT_TRUE(store::SqliteStore::open(file.string(), store::SqliteStore::Access::kWrite));
  {
    auto database = store::Database::open(file.string(), store::Database::Mode::kReadWrite);
    ASSERT_TRUE(database && database->run("DROP TABLE session_certificates;"
                                          "DROP TABLE auxiliary_coverage;"
                                          "ALTER TABLE blocks DROP COLUMN is_auxiliary;"
                                          "ALTER TABLE streams DROP COLUMN auxiliary_values;"
                                          "DELETE FROM schema_migrations WHERE version >= 2"));
  }
  const std::string before = bytes_of(file);
  const std::string domain = std::to_string(tonus::testing::own_domain());
  tonus::testing::Process refused(tonus::testing::program("tonus-archive"),
                                  {"--store", file.string(), "--domain", domain}, folder / "log");
  EXPECT_EQ(refused.wait(20s), 1);
  EXPECT_NE(refused.output().find("brought to 2: certificates of sessions"), std::string::npos)
      << refused.output();
  EXPECT_NE(refused.output().find("--upgrade-schema"), std::string::npos);
  EXPECT_EQ(bytes_of(file), before);

  tonus::testing::Process allowed(tonus::testing::program("tonus-archive"),
                                  {"--store", file.string(), "--domain", domain, "--upgrade-schema"},
                                  folder / "log 2");
  const auto deadline = std::chrono::steady_clock::now() + 20s;
  while (allowed.output().find("info") == std::string::npos && std::chrono::steady_clock::now() < deadline)
    EXPECT_EQ(allowed.wait(20ms), tonus::testing::Process::kStillRunning) << allowed.output();
  allowed.signal(SIGTERM);
  EXPECT_EQ(allowed.wait(20s), 0) << allowed.output();
  const auto steps = store::SqliteStore::pending_upgrade(file.string());
  ASSERT_TRUE(steps);
  EXPECT_TRUE(steps->empty());
}

}  // namespace
}  // namespace tonus::archive::testing
