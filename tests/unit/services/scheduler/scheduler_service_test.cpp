#include "services/scheduler/scheduler_service.hpp"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <thread>

#include "idl/topics.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/contract/subject.hpp"
#include "services/runtime/drain.hpp"
#include "services/runtime/version.hpp"
#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::scheduler {
namespace {

using ::testing::HasSubstr;
using namespace std::chrono_literals;

template <typename T>
bus::TypedWriter<T> writer(bus::Bus& bus, const bus::Topic<T>& topic) {
  return std::move(*bus::TypedWriter<T>::create(bus, topic));
}

template <typename T>
bus::TypedReader<T> reader(bus::Bus& bus, const bus::Topic<T>& topic,
                           std::shared_ptr<bus::Notifier> notifier) {
  return std::move(*bus::TypedReader<T>::create(bus, topic, std::move(notifier)));
}

/// Rig, identification, archive and operator at the other end of the bus, in the test's own thread.
class Peers {
 public:
  explicit Peers(bus::Bus& bus, std::shared_ptr<bus::Notifier> notifier)
      : commands_(reader(bus, topics::kTrialCommand, notifier)),
        states_(reader(bus, topics::kSessionState, notifier)),
        replies_(reader(bus, topics::kSessionReply, notifier)),
        cues_(reader(bus, topics::kSessionCue, notifier)),
        plans_(reader(bus, topics::kSessionPlan, notifier)),
        requests_(writer(bus, topics::kSessionCommand)),
        outcomes_(writer(bus, topics::kTrialOutcome)),
        verdicts_(writer(bus, topics::kTrialVerdict)),
        receipts_(writer(bus, topics::kArchiveReceipt)),
        descriptions_(writer(bus, topics::kRigDescription)),
        rig_states_(writer(bus, topics::kRigState)),
        rig_commands_(reader(bus, topics::kRigCommand, notifier)),
        rig_replies_(writer(bus, topics::kRigReply)),
        health_(writer(bus, topics::kServiceHealth)) {
    v1::RigDescription description = testing::description_of_rig();
    description.moves_nothing_real(true);
    description.resumes_unattended(true);
    EXPECT_TRUE(descriptions_.write(description).has_value());
    v1::RigState rig;
    rig.rig_id(description.rig_id());
    rig.epoch(1);
    rig.mode(v1::RIG_FREE);
    EXPECT_TRUE(rig_states_.write(rig).has_value());
    for (const auto role : {v1::ROLE_RIG, v1::ROLE_IDENTIFICATION, v1::ROLE_ARCHIVE}) {
      v1::ServiceHealth health;
      health.instance_id(id_of("peer " + std::to_string(role)));
      health.role(role);
      health.is_ready(true);
      health.idl_hash(runtime::idl_hash());
      health.software_version(runtime::kVersion);
      EXPECT_TRUE(health_.write(health).has_value());
      reports_.push_back(health);
    }
  }

  void start(const std::string& protocol) {
    v1::SessionCommand command;
    command.session_id(id_of("session"));
    command.request_id(id_of("start"));
    command.request(v1::SESSION_START);
    command.protocol_toml(protocol);
    command.subject("s01");
    command.subject_facts(contract::unknown_subject());
    EXPECT_TRUE(requests_.write(command).has_value());
  }

  void step() {
    for (const auto& received : runtime::drain(plans_)) plan = received.value;
    auto& archive = reports_.back();
    archive.is_ready(!plan || archive_refusal.empty());
    archive.state(archive_refusal);
    for (const auto& health : reports_) (void)health_.write(health);
    for (const auto& received : runtime::drain(rig_commands_)) {
      v1::RigReply done;
      done.rig_id(received.value.rig_id());
      done.request_id(received.value.request_id());
      done.is_done(true);
      EXPECT_TRUE(rig_replies_.write(done).has_value());
    }
    for (const auto& received : runtime::drain(commands_)) answer(received.value);
    for (const auto& received : runtime::drain(states_)) state = received.value;
    for (const auto& received : runtime::drain(replies_)) reply = received.value;
    for (const auto& received : runtime::drain(cues_)) cues.push_back(received.value);
  }

  std::optional<v1::SessionState> state;
  std::optional<v1::SessionReply> reply;
  std::optional<v1::SessionPlan> plan;
  std::vector<v1::SessionCue> cues;
  std::map<Id, std::uint32_t> ran;  ///< Planned index by trial.
  std::size_t mute_after = 1000;    ///< Trials after which the rig says nothing.
  std::string archive_refusal;      ///< Why the archive is not ready, once it has seen the plan.

 private:
  void answer(const v1::TrialCommand& command) {
    if (!ran.contains(command.trial_id()) && ran.size() >= mute_after) return;
    ran[command.trial_id()] = command.program().planned_index();
    v1::TrialOutcome outcome;
    outcome.trial_id(command.trial_id());
    outcome.program(command.program());
    outcome.last_sequence(1999);
    outcome.sample_rate_Hz(200.0);
    v1::TrialVerdict verdict;
    verdict.trial_id(command.trial_id());
    verdict.is_valid(true);
    v1::ArchiveReceipt receipt;
    receipt.subject_id(command.trial_id());
    receipt.kind(v1::RECEIPT_TRIAL);
    EXPECT_TRUE(outcomes_.write(outcome).has_value());
    EXPECT_TRUE(verdicts_.write(verdict).has_value());
    EXPECT_TRUE(receipts_.write(receipt).has_value());
  }

  bus::TypedReader<v1::TrialCommand> commands_;
  bus::TypedReader<v1::SessionState> states_;
  bus::TypedReader<v1::SessionReply> replies_;
  bus::TypedReader<v1::SessionCue> cues_;
  bus::TypedReader<v1::SessionPlan> plans_;
  bus::TypedWriter<v1::SessionCommand> requests_;
  bus::TypedWriter<v1::TrialOutcome> outcomes_;
  bus::TypedWriter<v1::TrialVerdict> verdicts_;
  bus::TypedWriter<v1::ArchiveReceipt> receipts_;
  bus::TypedWriter<v1::RigDescription> descriptions_;
  bus::TypedWriter<v1::RigState> rig_states_;
  bus::TypedReader<v1::RigCommand> rig_commands_;
  bus::TypedWriter<v1::RigReply> rig_replies_;
  bus::TypedWriter<v1::ServiceHealth> health_;
  std::vector<v1::ServiceHealth> reports_;
};

class SchedulerServiceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    bus_ = open_bus();
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::unique_ptr<bus::Bus> open_bus() {
    bus::BusOptions options;
    options.vendor = bus::Vendor::kMemory;
    options.fabric = fabric_;
    return std::move(*bus::create_bus(options));
  }

  std::unique_ptr<SchedulerService> open_service(bus::Bus& bus) {
    runtime::CommonOptions options;
    options.rig = "test";
    auto service = SchedulerService::create(
        std::move(*SchedulerEndpoints::create(bus, notifier_)),
        std::move(*runtime::HealthReporter::create(bus, clock_, v1::ROLE_SCHEDULER, options)),
        std::move(*runtime::Roster::create(bus, clock_, notifier_)),
        std::move(*SessionFolder::open(folder_, "contract")),
        std::move(*LeaseSender::create(open_bus(), clock_)), "test", clock_);
    EXPECT_TRUE(service.has_value()) << (service ? "" : service.error().message);
    return std::move(*service);
  }

  /// Lets both sides act until `done`; false after 10 s.
  bool run(SchedulerService& service, Peers& peers, const std::function<bool()>& done) {
    const auto limit = clock_.now() + 10s;
    while (clock_.now() < limit) {
      const auto due = service.step();
      EXPECT_TRUE(due.has_value()) << (due ? "" : due.error().message);
      peers.step();
      if (done()) return true;
      (void)notifier_->wait_until(std::min(*due, clock_.now() + 20ms));
    }
    return false;
  }

  const std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) /
      (std::string("tonus_service_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
  SystemClock clock_;
  std::shared_ptr<bus::MemoryFabric> fabric_ = std::make_shared<bus::MemoryFabric>();
  std::shared_ptr<bus::Notifier> notifier_ = std::make_shared<bus::Notifier>();
  std::unique_ptr<bus::Bus> bus_;
};

TEST_F(SchedulerServiceTest, RunsASessionOverTheBusAndPutsItsJournalAway) {
  const auto service = open_service(*bus_);
  Peers peers(*bus_, notifier_);
  peers.start(testing::small_protocol());
  ASSERT_TRUE(
      run(*service, peers, [&] { return peers.state && peers.state->phase() == v1::SESSION_COMPLETED; }));
  EXPECT_EQ(peers.state->counted(), 8u);
  EXPECT_EQ(peers.ran.size(), 8u);
  EXPECT_TRUE(peers.reply->is_done());
  EXPECT_EQ(peers.plan->planned_trials(), 8u);
  EXPECT_EQ(peers.cues.size(), 2u);
  EXPECT_TRUE(std::filesystem::exists(folder_ / (to_hex(id_of("session")) + ".finished")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / (to_hex(id_of("session")) + ".journal")));
}

TEST_F(SchedulerServiceTest, TakesASessionUpAgainAfterItsDeath) {
  Peers peers(*bus_, notifier_);
  peers.mute_after = 3;
  auto service = open_service(*bus_);
  peers.start(testing::small_protocol());
  ASSERT_TRUE(run(*service, peers, [&] { return peers.state && peers.state->counted() == 3; }));
  service.reset();
  peers.mute_after = 1000;
  const auto restarted_bus = open_bus();
  const auto restarted = open_service(*restarted_bus);
  ASSERT_TRUE(run(*restarted, peers, [&] { return peers.state->phase() == v1::SESSION_COMPLETED; }));
  EXPECT_EQ(peers.ran.size(), 8u);
  std::map<std::uint32_t, int> times;
  for (const auto& [id, planned] : peers.ran) ++times[planned];
  EXPECT_EQ(times.size(), 8u);
}

TEST_F(SchedulerServiceTest, RefusesASessionThatHasBeen) {
  {
    const auto service = open_service(*bus_);
    Peers peers(*bus_, notifier_);
    peers.start(testing::small_protocol());
    ASSERT_TRUE(
        run(*service, peers, [&] { return peers.state && peers.state->phase() == v1::SESSION_COMPLETED; }));
  }
  const auto bus = open_bus();
  const auto service = open_service(*bus);
  Peers peers(*bus, notifier_);
  peers.start(testing::small_protocol());
  ASSERT_TRUE(run(*service, peers, [&] { return peers.reply.has_value(); }));
  EXPECT_FALSE(peers.reply->is_done());
  EXPECT_THAT(peers.reply->message(), HasSubstr("has been: a new session needs a new id"));
  EXPECT_TRUE(peers.ran.empty());
}

TEST_F(SchedulerServiceTest, BeginsNoTrialOfAPlanThatTheArchiveHasNoRoomFor) {
  const auto service = open_service(*bus_);
  Peers peers(*bus_, notifier_);
  peers.archive_refusal = "no room for it";
  peers.start(testing::small_protocol());
  ASSERT_TRUE(run(*service, peers, [&] {
    return peers.state && peers.state->waiting_for().find("no room for it") != std::string::npos;
  }));
  EXPECT_EQ(peers.state->phase(), v1::SESSION_PREPARING);
  EXPECT_TRUE(peers.ran.empty());
  peers.archive_refusal.clear();
  ASSERT_TRUE(run(*service, peers, [&] { return peers.state->phase() == v1::SESSION_COMPLETED; }));
  EXPECT_EQ(peers.ran.size(), 8u);
}

TEST_F(SchedulerServiceTest, WaitsInMidSessionForAnArchiveThatHasNoRoomLeft) {
  const auto service = open_service(*bus_);
  Peers peers(*bus_, notifier_);
  peers.start(testing::small_protocol());
  ASSERT_TRUE(run(*service, peers, [&] { return peers.state && peers.state->counted() >= 3; }));
  peers.archive_refusal = "no room left";
  ASSERT_TRUE(run(*service, peers, [&] { return peers.state->phase() == v1::SESSION_WAITING; }));
  EXPECT_THAT(peers.state->waiting_for(), HasSubstr("archive is not ready: no room left"));
  EXPECT_LT(peers.ran.size(), 8u);
  peers.archive_refusal.clear();
  ASSERT_TRUE(run(*service, peers, [&] { return peers.state->phase() == v1::SESSION_COMPLETED; }));
  EXPECT_EQ(peers.state->counted(), 8u);
}

TEST_F(SchedulerServiceTest, StopsWhenItsJournalCannotBeMade) {
  const auto service = open_service(*bus_);
  Peers peers(*bus_, notifier_);
  std::filesystem::remove_all(folder_);
  peers.start(testing::small_protocol());
  Result<Clock::TimePoint> due = service->step();
  EXPECT_FALSE(due.has_value());
  EXPECT_EQ(due.error().code, ErrorCode::kNotFound);
  peers.step();
  EXPECT_FALSE(peers.reply.has_value());
  EXPECT_TRUE(peers.ran.empty());
}

}  // namespace
}  // namespace tonus::scheduler
