#include <csignal>
#include <gtest/gtest.h>

#include "idl/topics.hpp"
#include "services/core/clock.hpp"
#include "services/store/open_store.hpp"
#include "tests/fault/archive/rig_end.hpp"
#include "tests/support/postgres/postgres_server.hpp"
#include "tests/support/process.hpp"

#include <idl/service.h>

namespace tonus::archive::testing {
namespace {

using namespace std::chrono_literals;
using tonus::testing::PostgresServer;
using tonus::testing::Process;

/// tonus-archive on a real server, and a made-up rig.
class PostgresRestart : public ::testing::Test {
 protected:
  void SetUp() override {
    auto server = PostgresServer::start();
    if (!server && server.error().code == ErrorCode::kNotFound) GTEST_SKIP() << server.error().message;
    ASSERT_TRUE(server) << server.error().message;
    server_ = std::move(*server);
    url_ = *server_->make_database();
    const int domain = tonus::testing::own_domain();
    archive_ = std::make_unique<Process>(
        tonus::testing::program("tonus-archive"),
        std::vector<std::string>{"--store", url_, "--domain", std::to_string(domain)},
        folder_ / "archive.log");
    auto end = RigEnd::create(rig_, domain, bus::Vendor::kFastDds, notifier_);
    ASSERT_TRUE(end) << end.error().message;
    end_.emplace(std::move(*end));
    health_.emplace(
        *bus::TypedReader<v1::ServiceHealth>::create(end_->bus(), topics::kServiceHealth, notifier_));
    ASSERT_TRUE(eventually([this] { return end_->is_heard(); })) << archive_->output();
  }

  bool eventually(const std::function<bool()>& condition) {
    const auto deadline = clock_.now() + 30s;
    while (!condition()) {
      if (clock_.now() > deadline) return false;
      EXPECT_TRUE(end_->answer());
      std::vector<bus::Received<v1::ServiceHealth>> reports;
      health_->take(reports);
      if (!reports.empty()) archive_health_ = reports.back().value;
      static_cast<void>(notifier_->wait_until(clock_.now() + 10ms));
    }
    return true;
  }

  SystemClock clock_;
  std::shared_ptr<bus::Notifier> notifier_ = std::make_shared<bus::Notifier>();
  tonus::testing::TemporaryFolder folder_;
  std::unique_ptr<PostgresServer> server_;
  std::string url_;
  MadeUpRig rig_{1};
  std::unique_ptr<Process> archive_;
  std::optional<RigEnd> end_;
  std::optional<bus::TypedReader<v1::ServiceHealth>> health_;
  v1::ServiceHealth archive_health_;
};

TEST_F(PostgresRestart, LosesNothingWhenTheServerIsKilledInMidSession) {
  for (int i = 0; i < 3; ++i) end_->run_trial();
  ASSERT_TRUE(eventually([this] { return rig_.trials_without_receipt().empty(); })) << archive_->output();
  end_->run_trial();
  server_->kill();
  for (int i = 0; i < 3; ++i) end_->run_trial();
  ASSERT_TRUE(eventually([this] {
    return !archive_health_.is_ready() && archive_health_.state().find("its server") != std::string::npos;
  })) << archive_health_.state();
  EXPECT_GE(rig_.trials_without_receipt().size(), 3U);

  const auto restarted = server_->restart();
  ASSERT_TRUE(restarted) << restarted.error().message;
  ASSERT_TRUE(eventually([this] {
    return rig_.trials_without_receipt().empty() && rig_.through() == rig_.next_sequence();
  })) << archive_->output();
  ASSERT_TRUE(eventually([this] { return archive_health_.is_ready(); })) << archive_health_.state();
  archive_->signal(SIGTERM);
  EXPECT_EQ(archive_->wait(10s), 0) << archive_->output();

  const auto store = store::open_store_for_reading(url_);
  ASSERT_TRUE(store) << store.error().message;
  const auto whole = rig_.check(**store);
  EXPECT_TRUE(whole) << whole.error().message;
  EXPECT_EQ((*store)->trials(MadeUpRig::session())->size(), 7U);
}

}  // namespace
}  // namespace tonus::archive::testing
