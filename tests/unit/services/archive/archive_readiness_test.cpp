#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/archive/archive_service.hpp"
#include "services/archive/disk_watch.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/runtime/drain.hpp"
#include "services/runtime/health.hpp"
#include "services/store/sqlite_store.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/store/made_up.hpp"

/// What a roster learns of an archive whose store is full, failing or too small.
namespace tonus::archive {
namespace {

using store::testing::kEpoch;
using store::testing::kRig;
using store::testing::kSession;
using ::testing::HasSubstr;

class ArchiveReadiness : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kLimit = 1'000'000;

  void SetUp() override {
    bus::BusOptions options;
    options.vendor = bus::Vendor::kMemory;
    options.fabric = std::make_shared<bus::MemoryFabric>();
    bus_ = std::move(*bus::create_bus(options));
    samples_.emplace(*bus::TypedWriter<v1::SampleBlock>::create(*bus_, topics::kRigSamples));
    outcomes_.emplace(*bus::TypedWriter<v1::TrialOutcome>::create(*bus_, topics::kTrialOutcome));
    descriptions_.emplace(*bus::TypedWriter<v1::RigDescription>::create(*bus_, topics::kRigDescription));
    states_.emplace(*bus::TypedWriter<v1::SessionState>::create(*bus_, topics::kSessionState));
    receipts_.emplace(*bus::TypedReader<v1::ArchiveReceipt>::create(*bus_, topics::kArchiveReceipt, nullptr));
    roster_.emplace(*runtime::Roster::create(*bus_, clock_, nullptr));

    auto store = store::SqliteStore::open(folder_ / "study.sqlite", store::SqliteStore::Access::kWrite);
    ASSERT_TRUE(store) << store.error().message;
    store_ = std::move(*store);
    ingest_ = std::make_unique<Ingest>(*store_, clock_);
    ASSERT_TRUE(ingest_->recover());
    DiskBudget::Options disk;
    disk.limit_bytes = kLimit;
    disk.reserve_bytes = 0;
    disk_ = std::make_unique<DiskWatch>(*store_, clock_, disk);
    service_ = std::move(*ArchiveService::create(*bus_, *ingest_, clock_, nullptr, disk_.get()));
    health_.emplace(*runtime::HealthReporter::create(*bus_, clock_, v1::ROLE_ARCHIVE, {}));
    v1::RigDescription rig;
    rig.rig_id(kRig);
    rig.sample_rate_Hz(200.0);
    ASSERT_TRUE(descriptions_->write(rig));
  }

  /// What keeps a scheduler from beginning a trial, after the archive has handled what has come.
  std::string missing() {
    clock_.advance(std::chrono::seconds(1));
    service_->step();
    const std::string why = service_->why_not_ready();
    health_->set_state(why.empty(), why.empty() ? "stores" : why);
    health_->publish_if_due();
    roster_->update();
    return roster_->missing({v1::ROLE_ARCHIVE});
  }

  void send_session(v1::SessionPhase phase, std::uint32_t attempts, double remaining_s) {
    v1::SessionState state;
    state.session_id(kSession);
    state.phase(phase);
    state.attempts(attempts);
    state.remaining_s(remaining_s);
    ASSERT_TRUE(states_->write(state));
  }

  /// A trial of 1000 samples.
  void send_trial() {
    ++trials_;
    for (int i = 0; i < 50; ++i) {
      v1::SampleBlock block;
      block.rig_id(kRig);
      block.session_id(kSession);
      block.epoch(kEpoch);
      block.first_sequence(next_);
      block.samples().resize(20);
      next_ += 20;
      ASSERT_TRUE(samples_->write(block));
    }
    v1::TrialOutcome outcome;
    outcome.trial_id(trial_id(kSession, trials_));
    outcome.program().session_id(kSession);
    outcome.program().rig_id(kRig);
    outcome.program().attempt(trials_);
    outcome.epoch(kEpoch);
    outcome.first_sequence(next_ - 1000);
    outcome.last_sequence(next_ - 1);
    ASSERT_TRUE(outcomes_->write(outcome));
  }

  std::size_t trial_receipts() {
    std::size_t count = 0;
    for (const auto& receipt : runtime::drain(*receipts_))
      count += receipt.value.kind() == v1::RECEIPT_TRIAL ? 1 : 0;
    return count;
  }

  tonus::testing::TemporaryFolder folder_;
  ManualClock clock_;
  std::unique_ptr<bus::Bus> bus_;
  std::optional<bus::TypedWriter<v1::SampleBlock>> samples_;
  std::optional<bus::TypedWriter<v1::TrialOutcome>> outcomes_;
  std::optional<bus::TypedWriter<v1::RigDescription>> descriptions_;
  std::optional<bus::TypedWriter<v1::SessionState>> states_;
  std::optional<bus::TypedReader<v1::ArchiveReceipt>> receipts_;
  std::optional<runtime::Roster> roster_;
  std::unique_ptr<store::Store> store_;
  std::unique_ptr<Ingest> ingest_;
  std::unique_ptr<DiskWatch> disk_;
  std::unique_ptr<ArchiveService> service_;
  std::optional<runtime::HealthReporter> health_;
  std::uint64_t next_ = 0;
  std::uint32_t trials_ = 0;
};

TEST_F(ArchiveReadiness, RefusesASessionThatItHasNoRoomFor) {
  send_trial();
  EXPECT_EQ(missing(), "");
  send_session(v1::SESSION_PREPARING, 0, 600.0);
  const std::string cause = missing();
  EXPECT_THAT(cause, HasSubstr("the session needs about 10.3 MB"));  // 600 s x 200 Hz x 68.4 bytes x 1.25
  send_trial();
  EXPECT_EQ(missing(), cause);  // not another text for each byte
  send_session(v1::SESSION_ABORTED, 0, 0.0);
  EXPECT_EQ(missing(), "");
  send_session(v1::SESSION_PREPARING, 0, 10.0);
  EXPECT_EQ(missing(), "");
  EXPECT_THAT(disk_->need_text(), HasSubstr("the session needs about"));
}

TEST_F(ArchiveReadiness, AsksForAPauseBeforeItsLimitAndStillTakesTheTrialThatRuns) {
  send_session(v1::SESSION_RUNNING, 1, 600.0);
  std::string cause;
  while (cause.empty() && trials_ < 100) {
    send_trial();
    cause = missing();
    EXPECT_EQ(trial_receipts(), 1U);
  }
  EXPECT_THAT(cause, HasSubstr("archive is not ready"));
  EXPECT_THAT(cause, HasSubstr("its disk budget is used up: "));
  EXPECT_LT(store_->space()->used_bytes, kLimit + 200'000);
  EXPECT_GT(trials_, 3U);
  send_trial();
  EXPECT_NE(missing(), "");
  EXPECT_EQ(trial_receipts(), 1U);
}

TEST_F(ArchiveReadiness, NamesAStoreThatFailsAndGivesNoReceipt) {
  send_trial();
  EXPECT_EQ(missing(), "");
  EXPECT_EQ(trial_receipts(), 1U);
  std::filesystem::rename(folder_ / "study.sqlite", folder_ / "away.sqlite");
  send_trial();
  EXPECT_THAT(missing(), HasSubstr("study.sqlite': was removed or replaced"));
  EXPECT_EQ(trial_receipts(), 0U);
  std::filesystem::rename(folder_ / "away.sqlite", folder_ / "study.sqlite");
  EXPECT_EQ(missing(), "");
  EXPECT_EQ(trial_receipts(), 1U);
}

TEST_F(ArchiveReadiness, GivesTheReceiptOfASessionThatHasEnded) {
  send_trial();
  send_trial();
  EXPECT_EQ(missing(), "");
  send_session(v1::SESSION_COMPLETED, 2, 0.0);
  EXPECT_EQ(missing(), "");
  std::vector<v1::ArchiveReceipt> sessions;
  for (const auto& receipt : runtime::drain(*receipts_)) {
    if (receipt.value.kind() == v1::RECEIPT_SESSION) sessions.push_back(receipt.value);
  }
  ASSERT_EQ(sessions.size(), 1U);
  EXPECT_EQ(sessions[0].subject_id(), kSession);
  EXPECT_EQ(sessions[0].session_id(), kSession);
  EXPECT_EQ(sessions[0].rig_id(), kRig);
  EXPECT_EQ(sessions[0].expected_samples(), 2000U);
  EXPECT_EQ(sessions[0].received_samples(), 2000U);
  EXPECT_EQ(sessions[0].missing_samples(), 0U);
}

}  // namespace
}  // namespace tonus::archive
