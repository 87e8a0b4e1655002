#include "services/archive/archive_service.hpp"

#include <gtest/gtest.h>

#include "services/bus/memory/memory_fabric.hpp"
#include "services/store/sample_reader.hpp"
#include "services/store/sqlite_store.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/store/made_up.hpp"

/// The service on a bus within the process, with a store on the disk.
namespace tonus::archive {
namespace {

using store::testing::kEpoch;
using store::testing::kRig;
using store::testing::kSession;

class ArchiveServiceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    rig_bus_ = make_bus("rig");
    samples_.emplace(*bus::TypedWriter<v1::SampleBlock>::create(*rig_bus_, topics::kRigSamples));
    outcomes_.emplace(*bus::TypedWriter<v1::TrialOutcome>::create(*rig_bus_, topics::kTrialOutcome));
    states_.emplace(*bus::TypedWriter<v1::RigState>::create(*rig_bus_, topics::kRigState));
    receipts_.emplace(
        *bus::TypedReader<v1::ArchiveReceipt>::create(*rig_bus_, topics::kArchiveReceipt, nullptr));
    resends_.emplace(
        *bus::TypedReader<v1::ArchiveResend>::create(*rig_bus_, topics::kArchiveResend, nullptr));
    start();
  }

  std::unique_ptr<bus::Bus> make_bus(const std::string& name) {
    bus::BusOptions options;
    options.vendor = bus::Vendor::kMemory;
    options.participant_name = name;
    options.fabric = fabric_;
    return std::move(*bus::create_bus(options));
  }

  void start() {
    auto store = store::SqliteStore::open(folder_ / "study.sqlite", store::SqliteStore::Access::kWrite);
    ASSERT_TRUE(store) << store.error().message;
    store_ = std::move(*store);
    ingest_ = std::make_unique<Ingest>(*store_, clock_);
    ASSERT_TRUE(ingest_->recover());
    archive_bus_ = make_bus("archive");
    auto service = ArchiveService::create(*archive_bus_, *ingest_, clock_, std::make_shared<bus::Notifier>());
    ASSERT_TRUE(service) << service.error().message;
    service_ = std::move(*service);
  }

  void stop() {
    service_.reset();
    archive_bus_.reset();
    ingest_.reset();
    store_.reset();
  }

  void send_samples(std::uint64_t first, std::uint64_t end, bool is_resent = false) {
    for (; first < end; first += 20) {
      v1::SampleBlock block;
      block.rig_id(kRig);
      block.session_id(kSession);
      block.trial_id(trial_id(kSession, 1));
      block.epoch(kEpoch);
      block.first_sequence(first);
      block.is_resent(is_resent);
      block.samples().resize(20);
      for (std::size_t i = 0; i < 20; ++i)
        block.samples()[i].acquisition_ns(static_cast<std::int64_t>(first + i));
      ASSERT_TRUE(samples_->write(block));
    }
  }

  void send_outcome(std::uint64_t first, std::uint64_t last) {
    v1::TrialOutcome outcome;
    outcome.trial_id(trial_id(kSession, 1));
    outcome.program().session_id(kSession);
    outcome.program().rig_id(kRig);
    outcome.epoch(kEpoch);
    outcome.first_sequence(first);
    outcome.last_sequence(last);
    ASSERT_TRUE(outcomes_->write(outcome));
  }

  void send_state(std::uint64_t next_sequence) {
    v1::RigState state;
    state.rig_id(kRig);
    state.epoch(kEpoch);
    state.next_sequence(next_sequence);
    state.rig_clock_ns(++states_sent_);
    ASSERT_TRUE(states_->write(state));
  }

  std::vector<v1::ArchiveReceipt> trial_receipts() {
    std::vector<bus::Received<v1::ArchiveReceipt>> received;
    receipts_->take(received);
    std::vector<v1::ArchiveReceipt> receipts;
    for (const auto& receipt : received) {
      if (receipt.value.kind() == v1::RECEIPT_TRIAL) receipts.push_back(receipt.value);
    }
    return receipts;
  }

  tonus::testing::TemporaryFolder folder_;
  std::shared_ptr<bus::MemoryFabric> fabric_ = std::make_shared<bus::MemoryFabric>();
  std::unique_ptr<bus::Bus> rig_bus_;
  std::optional<bus::TypedWriter<v1::SampleBlock>> samples_;
  std::optional<bus::TypedWriter<v1::TrialOutcome>> outcomes_;
  std::optional<bus::TypedWriter<v1::RigState>> states_;
  std::optional<bus::TypedReader<v1::ArchiveReceipt>> receipts_;
  std::optional<bus::TypedReader<v1::ArchiveResend>> resends_;
  std::int64_t states_sent_ = 0;

  ManualClock clock_;
  std::unique_ptr<store::Store> store_;
  std::unique_ptr<Ingest> ingest_;
  std::unique_ptr<bus::Bus> archive_bus_;
  std::unique_ptr<ArchiveService> service_;
};

TEST_F(ArchiveServiceTest, GivesAReceiptForATrialInOneStep) {
  send_samples(0, 1400);
  send_outcome(0, 1399);
  service_->step();
  const auto receipts = trial_receipts();
  ASSERT_EQ(receipts.size(), 1U);
  EXPECT_EQ(receipts[0].subject_id(), trial_id(kSession, 1));
  EXPECT_EQ(receipts[0].received_samples(), 1400U);
  const auto samples = store::read_samples(*store_, {kRig, kEpoch}, {0, 1400});
  ASSERT_TRUE(samples) << samples.error().message;
  EXPECT_EQ(samples->at(1234).acquisition_ns(), 1234);
}

TEST_F(ArchiveServiceTest, TakesMoreThanOneStepHolds) {
  send_samples(0, 15'000);  // 750 blocks
  send_outcome(0, 14'999);
  EXPECT_LE(service_->step(), clock_.now());
  service_->step();
  EXPECT_EQ(trial_receipts().size(), 1U);
}

TEST_F(ArchiveServiceTest, GetsWhatItMissedWhileItWasGone) {
  send_samples(0, 100);
  service_->step();
  clock_.advance(std::chrono::milliseconds(200));
  service_->step();
  stop();
  send_samples(100, 300);
  send_outcome(0, 299);
  send_state(300);
  start();
  service_->step();
  EXPECT_TRUE(trial_receipts().empty());
  clock_.advance(std::chrono::milliseconds(100));
  service_->step();
  std::vector<bus::Received<v1::ArchiveResend>> requests;
  resends_->take(requests);
  ASSERT_EQ(requests.size(), 1U);
  EXPECT_EQ(requests[0].value.first_sequence(), 100U);
  EXPECT_EQ(requests[0].value.last_sequence(), 299U);
  send_samples(100, 300, true);
  service_->step();
  const auto receipts = trial_receipts();
  ASSERT_EQ(receipts.size(), 1U);
  EXPECT_EQ(receipts[0].resent_samples(), 200U);
  EXPECT_EQ(receipts[0].missing_samples(), 0U);
}

TEST_F(ArchiveServiceTest, GivesReceiptsOnceMoreAfterARestart) {
  bus::TypedWriter<v1::SessionPlan> plans(
      *bus::TypedWriter<v1::SessionPlan>::create(*rig_bus_, topics::kSessionPlan));
  v1::SessionPlan plan;
  plan.session_id(kSession);
  plan.started_at("2026-03-01T10:00:00Z");
  ASSERT_TRUE(plans.write(plan));
  send_samples(0, 100);
  send_outcome(0, 99);
  service_->step();
  EXPECT_EQ(trial_receipts().size(), 1U);
  stop();
  start();
  service_->step();
  EXPECT_GE(trial_receipts().size(), 1U);
}

TEST_F(ArchiveServiceTest, IsReadyWhenThereIsARigAndAStoreThatTakesData) {
  EXPECT_EQ(service_->why_not_ready(), "");
  samples_.reset();
  EXPECT_EQ(service_->why_not_ready(), "waits for a rig");
  samples_.emplace(*bus::TypedWriter<v1::SampleBlock>::create(*rig_bus_, topics::kRigSamples));
  EXPECT_EQ(service_->why_not_ready(), "");
  std::filesystem::remove(folder_ / "study.sqlite");
  send_samples(0, 100);
  send_outcome(0, 99);
  service_->step();
  EXPECT_NE(service_->why_not_ready().find("was removed or replaced"), std::string::npos);
  EXPECT_TRUE(trial_receipts().empty());
}

TEST_F(ArchiveServiceTest, CountsWhatItCannotUse) {
  v1::SampleBlock empty;
  empty.rig_id(kRig);
  ASSERT_TRUE(samples_->write(empty));
  service_->step();
  EXPECT_EQ(service_->dropped(), 1U);
}

}  // namespace
}  // namespace tonus::archive
