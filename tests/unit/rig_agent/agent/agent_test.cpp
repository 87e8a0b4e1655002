#include <csignal>
#include <sys/resource.h>

#include "tests/unit/rig_agent/agent/agent_fixture.hpp"

namespace tonus::rig {
namespace {

TEST_F(AgentTest, RunsATrialAndPublishesEverySampleOfItBeforeTheOutcome) {
  ASSERT_TRUE(commands_->write(command(1)));
  const auto outcome = run_to_outcome();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->end(), v1::TRIAL_COMPLETED) << outcome->detail();
  std::uint64_t next = outcome->first_sequence();
  for (const auto& block : blocks_) {
    if (block.trial_id() != outcome->trial_id()) continue;
    EXPECT_EQ(block.first_sequence(), next);
    next += block.samples().size();
  }
  EXPECT_EQ(next, outcome->last_sequence() + 1);
  // 200 Hz: 3 s of waiting and 1.5 s of perturbation at least, centring and way back besides.
  EXPECT_GE(outcome->last_sequence() - outcome->first_sequence(), 900U);
  EXPECT_GE(outcome->onset_sequence() - outcome->first_sequence(), 600U);
}

TEST_F(AgentTest, DoesNotRunTheSameTrialTwice) {
  ASSERT_TRUE(commands_->write(command(1)));
  const auto first = run_to_outcome();
  blocks_.clear();
  ASSERT_TRUE(commands_->write(command(1)));
  const auto second = run_to_outcome();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(second->last_sequence(), first->last_sequence());
  EXPECT_TRUE(blocks_.empty());
}

TEST_F(AgentTest, RefusesATrialWhileAnotherRuns) {
  ASSERT_TRUE(commands_->write(command(1)));
  agent_->step();
  ASSERT_TRUE(commands_->write(command(2)));
  const auto outcome = run_to_outcome();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->end(), v1::TRIAL_REFUSED);
  EXPECT_EQ(outcome->detail(), "trial 1 is running");
}

TEST_F(AgentTest, RefusesAProgramThatWouldLeaveTheWorkspaceAndNamesTheValue) {
  auto far = command(1);
  far.program().amplitude_m(0.5);
  ASSERT_TRUE(commands_->write(far));
  const auto outcome = run_to_outcome();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->end(), v1::TRIAL_REFUSED);
  EXPECT_NE(outcome->detail().find("radius 0.08 less twice the amplitude"), std::string::npos)
      << outcome->detail();
}

TEST_F(AgentTest, AnswersARefusedTrialAlikeWhenItsCommandIsRepeated) {
  auto far = command(1);
  far.program().amplitude_m(0.5);
  ASSERT_TRUE(commands_->write(far));
  const auto first = run_to_outcome();
  ASSERT_TRUE(commands_->write(command(1)));  // The same trial, which could be run as it stands now.
  const auto second = run_to_outcome();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(second->end(), v1::TRIAL_REFUSED);
  EXPECT_EQ(second->detail(), first->detail());
  start_armed(2000);
  const auto after_restart = run_to_outcome();
  ASSERT_TRUE(after_restart);
  EXPECT_EQ(after_restart->end(), v1::TRIAL_REFUSED);
}

TEST_F(AgentTest, SendsSpooledSamplesAgainWhenAsked) {
  ASSERT_TRUE(commands_->write(command(1)));
  const auto outcome = run_to_outcome();
  ASSERT_TRUE(outcome);
  blocks_.clear();
  v1::ArchiveResend request;
  request.rig_id(rig_->names().id);
  request.epoch(1000);
  request.first_sequence(outcome->first_sequence());
  request.last_sequence(outcome->last_sequence());
  ASSERT_TRUE(resends_->write(request));
  agent_->step();
  collect_blocks();
  std::uint64_t samples = 0;
  for (const auto& block : blocks_) {
    EXPECT_TRUE(block.is_resent());
    samples += block.samples().size();
  }
  EXPECT_EQ(samples, outcome->last_sequence() - outcome->first_sequence() + 1);
}

TEST_F(AgentTest, ReportsATrialThatItsDeathBrokeOffAndKeepsItsSamples) {
  ASSERT_TRUE(commands_->write(command(1)));
  agent_->step();  // two seconds into the trial
  start_armed(2000);
  const auto outcome = run_to_outcome();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->end(), v1::TRIAL_BROKEN_OFF);
  EXPECT_EQ(outcome->epoch(), 1000U);
  EXPECT_GT(outcome->last_sequence(), outcome->first_sequence());
  EXPECT_FALSE(spool_->left_behind(2000).empty());
}

TEST_F(AgentTest, AnEmergencyStopEndsTheTrialAndIsAnsweredAfterItsEffect) {
  ASSERT_TRUE(commands_->write(command(1)));
  agent_->step();
  v1::RigCommand stop;
  stop.rig_id(rig_->names().id);
  stop.request_id(random_id());
  stop.request(v1::RIG_EMERGENCY_STOP);
  ASSERT_TRUE(rig_commands_->write(stop));
  const auto outcome = run_to_outcome();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->end(), v1::TRIAL_FAULTED);
  EXPECT_EQ(outcome->detail(), "fault: emergency_stop");
  const auto replies = runtime::drain(*rig_replies_);
  ASSERT_EQ(replies.size(), 1U);
  EXPECT_EQ(replies[0].value.request_id(), stop.request_id());
}

TEST_F(AgentTest, RefusesATrialWhileTheSpoolIsFullAlsoWhenNobodyReads) {
  ASSERT_TRUE(commands_->write(command(1)));
  ASSERT_TRUE(run_to_outcome());
  samples_.reset();
  spool_bytes_ = 1000;
  start_armed(2000);
  (void)runtime::drain(*outcomes_);
  ASSERT_TRUE(commands_->write(command(2)));
  for (int i = 0; i < 10; ++i) agent_->step();
  const auto outcomes = runtime::drain(*outcomes_);
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_EQ(outcomes[0].value.end(), v1::TRIAL_REFUSED);
  EXPECT_EQ(outcomes[0].value.detail().rfind("the spool is full: ", 0), 0U) << outcomes[0].value.detail();
}

TEST_F(AgentTest, RunsATrialThatNobodyReadsWhileTheSpoolKeepsItsSamples) {
  samples_.reset();
  ASSERT_TRUE(commands_->write(command(1)));
  std::vector<bus::Received<v1::TrialOutcome>> outcomes;
  for (int i = 0; i < 1000 && outcomes.empty(); ++i) {
    agent_->step();
    outcomes = runtime::drain(*outcomes_);
  }
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_EQ(outcomes[0].value.end(), v1::TRIAL_COMPLETED) << outcomes[0].value.detail();
}

TEST_F(AgentTest, RefusesATrialWhoseStartTheLoopCannotTakeAndAnswersEveryRequestOfAFlood) {
  start_armed(1000, true);
  constexpr int kFlood = 200;
  std::size_t answers = 0;
  for (int i = 0; i < kFlood; ++i) {
    v1::RigCommand abort;
    abort.rig_id(rig_->names().id);
    abort.request_id(random_id());
    abort.request(v1::RIG_ABORT_TRIAL);
    ASSERT_TRUE(rig_commands_->write(abort));
  }
  ASSERT_TRUE(commands_->write(command(1)));
  agent_->step();  // the loop stands still: its queue fills up
  for (const auto& received : runtime::drain(*outcomes_)) {
    EXPECT_EQ(received.value.end(), v1::TRIAL_REFUSED);
    EXPECT_EQ(received.value.detail(), "too many requests wait for the loop");
    ++answers;
  }
  ASSERT_EQ(answers, 1U);
  EXPECT_EQ(agent_->activity(), "idle");
  answers = runtime::drain(*rig_replies_).size();
  std::int64_t now = 0;
  for (int i = 0; i < 10; ++i) {
    rig_->loop().step(now += 1'000'000);
    agent_->step();
    answers += runtime::drain(*rig_replies_).size();
  }
  EXPECT_EQ(answers, static_cast<std::size_t>(kFlood));
}

/// While one lives, no file of this process can grow.
class FullDisk {
 public:
  FullDisk() {
    getrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, SIG_IGN);
    const rlimit none{0, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &none);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

TEST_F(AgentTest, TellsNobodyOfAnEndThatIsNotInItsLogUntilItIs) {
  ASSERT_TRUE(commands_->write(command(1)));
  agent_->step();
  {
    FullDisk disk;
    for (int i = 0; i < 1000 && agent_->activity() != "idle"; ++i) agent_->step();
    ASSERT_EQ(agent_->activity(), "idle");
    ASSERT_TRUE(commands_->write(command(1)));  // the scheduler asks again
    agent_->step();
    EXPECT_TRUE(runtime::drain(*outcomes_).empty());
  }
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  auto outcome = run_to_outcome();
  while (!outcome && std::chrono::steady_clock::now() < deadline) outcome = run_to_outcome();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->end(), v1::TRIAL_COMPLETED);
}

TEST_F(AgentTest, ATrialWhoseEndWasNotLoggedIsBrokenOffAfterItsDeathAndWasNeverSaidToBeComplete) {
  ASSERT_TRUE(commands_->write(command(1)));
  agent_->step();
  {
    FullDisk disk;
    for (int i = 0; i < 1000 && agent_->activity() != "idle"; ++i) agent_->step();
    EXPECT_TRUE(runtime::drain(*outcomes_).empty());
    stop_agent();
  }
  start_armed(2000);
  const auto outcome = run_to_outcome();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->end(), v1::TRIAL_BROKEN_OFF);
}

TEST_F(AgentTest, ATrialOfWhichNoSampleWasKeptWasNotRun) {
  start_armed(1000, true);
  ASSERT_TRUE(commands_->write(command(1)));
  agent_->step();  // no cycle of the loop
  start_armed(2000);
  const auto outcome = run_to_outcome();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->end(), v1::TRIAL_REFUSED);
  EXPECT_EQ(outcome->detail(), "the rig agent ended before the trial's first sample was kept");
}

TEST_F(AgentTest, AForgedReceiptFreesNothingAndIsNotRemembered) {
  ASSERT_TRUE(commands_->write(command(1)));
  ASSERT_TRUE(run_to_outcome());
  auto receipts = *bus::TypedWriter<v1::ArchiveReceipt>::create(*bus_, topics::kArchiveReceipt);
  const std::uint64_t last = spool_->last_sequence(epoch_).value();
  ASSERT_GT(last, 100U);
  const auto give = [&](std::uint64_t epoch, std::uint64_t first, std::uint64_t through) {
    v1::ArchiveReceipt receipt;
    receipt.rig_id(rig_->names().id);
    receipt.kind(v1::RECEIPT_STREAM);
    receipt.epoch(epoch);
    receipt.through_sequence(through);
    receipt.expected_samples(through - first);
    ASSERT_TRUE(receipts.write(receipt));
    agent_->step();
  };
  give(epoch_, 0, UINT64_MAX);
  give(epoch_, 0, std::uint64_t{1} << 62U);
  give(epoch_, last / 2, last);
  give(epoch_ + 1, 0, 100);
  EXPECT_TRUE(log_->received_through().empty());
  give(epoch_, 0, last / 2);
  ASSERT_EQ(log_->received_through().size(), 1U);
  EXPECT_EQ(log_->received_through().at(epoch_), last / 2);
}

TEST_F(AgentTest, BeginsNoTrialWhileItsLogCannotBeWrittenAndGoesOnWhenItCan) {
  v1::ArchiveReceipt receipt;
  receipt.rig_id(rig_->names().id);
  receipt.kind(v1::RECEIPT_STREAM);
  receipt.epoch(1000);
  auto receipts = *bus::TypedWriter<v1::ArchiveReceipt>::create(*bus_, topics::kArchiveReceipt);
  {
    FullDisk disk;
    ASSERT_TRUE(receipts.write(receipt));
    agent_->step();
    EXPECT_EQ(agent_->why_not_ready().rfind("the trial log cannot be written: ", 0), 0U)
        << agent_->why_not_ready();
    ASSERT_TRUE(commands_->write(command(1)));
    agent_->step();
    const auto outcomes = runtime::drain(*outcomes_);
    ASSERT_EQ(outcomes.size(), 1U);
    EXPECT_EQ(outcomes[0].value.end(), v1::TRIAL_REFUSED);
  }
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!agent_->why_not_ready().empty() && std::chrono::steady_clock::now() < deadline) agent_->step();
  EXPECT_EQ(agent_->why_not_ready(), "");
  ASSERT_TRUE(commands_->write(command(2)));
  const auto outcome = run_to_outcome();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->end(), v1::TRIAL_COMPLETED) << outcome->detail();
  start_armed(2000);
  ASSERT_NE(log_->find(trial_id(kSession, 1)), nullptr) << "what happened meanwhile is in the log";
}

TEST_F(AgentTest, StopsThePacedLoopWithinTwoCyclesOfTheTopicsEmergencyStop) {
  start_armed(1000, true);
  std::int64_t now = 0;
  const auto cycle = [&] { rig_->loop().step(now += 1'000'000); };
  ASSERT_TRUE(commands_->write(command(1)));
  for (int i = 0; i < 3000 && rig_->loop().state().phase != control::Phase::kWaiting; ++i) {
    agent_->step();
    cycle();
  }
  ASSERT_EQ(rig_->loop().state().phase, control::Phase::kWaiting);
  v1::RigCommand stop;
  stop.rig_id(rig_->names().id);
  stop.request_id(random_id());
  stop.request(v1::RIG_EMERGENCY_STOP);
  ASSERT_TRUE(rig_commands_->write(stop));
  agent_->step();
  int cycles = 0;
  while (rig_->loop().state().phase != control::Phase::kSafe && cycles < 10) {
    cycle();
    ++cycles;
  }
  EXPECT_LE(cycles, 2);
  agent_->step();
  const auto replies = runtime::drain(*rig_replies_);
  ASSERT_EQ(replies.size(), 1U);
  EXPECT_TRUE(replies[0].value.is_done());
}

}  // namespace
}  // namespace tonus::rig
