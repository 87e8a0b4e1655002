#include <chrono>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/scheduler/session_machine.hpp"
#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::scheduler {
namespace {

using testing::counted_trials;
using testing::Fate;
using ::testing::HasSubstr;
using testing::Lab;
using testing::small_protocol;
using namespace std::chrono_literals;

/// Each planned trial of `count` is counted once.
void expect_each_counted_once(const Lab& lab, std::uint32_t count) {
  const auto counted = counted_trials(lab.records);
  EXPECT_EQ(counted.size(), count);
  for (const auto& [planned, times] : counted) EXPECT_EQ(times, 1) << "planned trial " << planned;
}

Lab::Script fate_of_attempt(std::uint32_t attempt, Fate fate) {
  return [=](const v1::TrialProgram& program) { return program.attempt() == attempt ? fate : Fate{}; };
}

struct Loss {
  const char* name;
  Fate fate;
  const char* reason;
};

class RejectedTrial : public ::testing::TestWithParam<Loss> {};

TEST_P(RejectedTrial, IsQueuedAgainInItsSetWithItsReasonKept) {
  Lab lab(fate_of_attempt(2, GetParam().fate));
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  ASSERT_TRUE(lab.run_until([&] { return lab.ledger().rejected == 1; }));
  const auto& rejected =
      std::get<record::Rejected>(*std::find_if(lab.records.begin(), lab.records.end(), [](const auto& r) {
        return std::holds_alternative<record::Rejected>(r);
      }));
  EXPECT_EQ(rejected.attempt, 2u);
  EXPECT_EQ(rejected.reason, GetParam().reason);
  EXPECT_THAT(lab.states.back().message(), HasSubstr(GetParam().reason));
  EXPECT_TRUE(lab.run_to_end());
  expect_each_counted_once(lab, 8);
  EXPECT_EQ(lab.trial_commands.size(), 9u);
  const auto& first = lab.trial_commands[1].program();
  const auto& repeat =
      lab.trial_commands[2].program();  // set one has two trials, so the repeat follows at once
  EXPECT_EQ(repeat.planned_index(), first.planned_index());
  EXPECT_EQ(repeat.attempt(), 3u);
  EXPECT_NE(repeat.wait_s(), first.wait_s());
  EXPECT_EQ(lab.phase(), v1::SESSION_COMPLETED);
}

INSTANTIATE_TEST_SUITE_P(Session, RejectedTrial,
                         ::testing::Values(Loss{"Verdict",
                                                {.detail = "8 mm from the target, allowed are 5",
                                                 .is_valid = false},
                                                "off target: 8 mm from the target, allowed are 5"},
                                           Loss{"Receipt",
                                                {.missing_samples = 3},
                                                "archive: 3 of 2000 samples are missing for good"},
                                           Loss{"BiasNotReached",
                                                {.end = v1::TRIAL_BIAS_NOT_REACHED, .detail = "0.3 of 0.8 N"},
                                                "bias not reached: 0.3 of 0.8 N"},
                                           Loss{"BrokenOff",
                                                {.end = v1::TRIAL_BROKEN_OFF, .detail = "agent restarted"},
                                                "broken off: agent restarted"}),
                         [](const auto& param) { return std::string(param.param.name); });

TEST(Session, ReviewsATrialThatWasValidAndThatTheArchiveCouldNotKeep) {
  Lab lab(fate_of_attempt(2, {.missing_samples = 3}));
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  ASSERT_TRUE(lab.run_to_end());
  ASSERT_EQ(lab.reviews.size(), 1U);
  const v1::TrialReview& review = lab.reviews.front();
  EXPECT_EQ(review.trial_id(), trial_id(Lab::kSession, 2));
  EXPECT_TRUE(review.is_rejected());
  EXPECT_EQ(review.reason(), "archive: 3 of 2000 samples are missing for good");
  EXPECT_EQ(review.reviewed_by(), "the scheduler");
  expect_each_counted_once(lab, 8);
  Ledger replayed;
  for (const Record& record : lab.records) ASSERT_TRUE(replayed.apply(record).has_value());
  ASSERT_EQ(replayed.state().reviews.size(), 1U);
  EXPECT_EQ(replayed.state().reviews.front().attempt, 2U);
}

TEST(Session, ReviewsNoTrialThatItsVerdictRejected) {
  Lab lab(fate_of_attempt(2, {.detail = "8 mm from the target", .is_valid = false, .missing_samples = 3}));
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  ASSERT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.ledger().rejected, 1U);
  EXPECT_TRUE(lab.reviews.empty());
}

TEST(Session, WaitsForTheOutcomeBeforeItRejects) {
  Lab lab(fate_of_attempt(1, {.end = v1::TRIAL_ABORTED, .detail = "by hand", .has_outcome = false}));
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.run();
  EXPECT_EQ(lab.ledger().rejected, 0u);
  EXPECT_EQ(lab.phase(), v1::SESSION_RUNNING);
}

TEST(Session, PausesWhenSomebodyElseAbortsATrial) {
  Lab lab(fate_of_attempt(3, {.end = v1::TRIAL_ABORTED, .detail = "by hand"}));
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.run();
  EXPECT_EQ(lab.phase(), v1::SESSION_PAUSED);
  EXPECT_EQ(lab.machine().state().message(), "trial 3 rejected: aborted: by hand");
  lab.command(v1::SESSION_RESUME, "go");
  EXPECT_TRUE(lab.reply_to("go")->is_done());
  EXPECT_TRUE(lab.run_to_end());
  expect_each_counted_once(lab, 8);
}

TEST(Session, AsksTheOperatorAtTheLimitOfRejections) {
  Lab lab([](const v1::TrialProgram& program) { return Fate{.is_valid = program.attempt() > 5}; });
  lab.command(v1::SESSION_START, "start", small_protocol("rejection_limit = 3\n"));
  lab.connect();
  lab.run();
  EXPECT_EQ(lab.phase(), v1::SESSION_WAITING);
  EXPECT_EQ(lab.ledger().rejected, 3u);
  EXPECT_EQ(
      lab.machine().state().waiting_for(),
      "operator: 3 trials rejected in set 1 at 'near', the limit is 3 (last: trial 3 rejected: off target); "
      "resume goes on");
  lab.command(v1::SESSION_RESUME, "go");
  EXPECT_TRUE(lab.reply_to("go")->is_done());
  EXPECT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.ledger().rejected, 5u);
  expect_each_counted_once(lab, 8);
}

TEST(Session, RepeatsACommandThatBringsNoOutcomeAndSaysSo) {
  Lab lab;
  lab.is_mute = true;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  ASSERT_EQ(lab.trial_commands.size(), 1u);
  lab.tick(1999ms);
  EXPECT_EQ(lab.trial_commands.size(), 1u);
  lab.tick(1ms);
  EXPECT_EQ(lab.trial_commands.size(), 2u);
  EXPECT_EQ(lab.trial_commands[1], lab.trial_commands[0]);
  EXPECT_EQ(lab.phase(), v1::SESSION_RUNNING);
  lab.tick(2s);
  EXPECT_EQ(lab.phase(), v1::SESSION_WAITING);
  EXPECT_EQ(lab.machine().state().waiting_for(), "rig: outcome of trial 1");
  lab.is_mute = false;
  EXPECT_TRUE(lab.run_to_end());
  expect_each_counted_once(lab, 8);
}

TEST(Session, GivesATrialInRealTimeTheTimeThatItTakes) {
  Lab lab;
  lab.is_mute = true;
  v1::RigState state;
  state.epoch(1);
  state.is_realtime_paced(true);
  state.mode(v1::RIG_FREE);
  lab.take(lab.machine().on_rig_state(state));
  lab.has_rig_state = true;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.tick(Patience{}.stillness);
  const double expected = protocol::expected_duration(lab.trial_commands[0].program());
  lab.tick(std::chrono::milliseconds(static_cast<int>(1000.0 * (1.25 * expected + 1.9))));
  EXPECT_EQ(lab.trial_commands.size(), 1u);
  lab.tick(200ms);
  EXPECT_EQ(lab.trial_commands.size(), 2u);
}

TEST(Session, DoesNotCallATrialStuckThatTheRigIsRunning) {
  Lab lab;
  lab.is_mute = true;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  v1::RigState state;
  state.epoch(1);
  state.mode(v1::RIG_IN_TRIAL);
  state.trial_id(trial_id(Lab::kSession, 1));
  lab.take(lab.machine().on_rig_state(state));
  for (int i = 0; i < 5; ++i) lab.tick(2s);
  EXPECT_EQ(lab.phase(), v1::SESSION_RUNNING);
}

TEST(Session, RepeatsTheCommandAtOnceWhenTheRigHasRestarted) {
  Lab lab;
  lab.is_mute = true;
  lab.give_rig_state(v1::RIG_FREE, 1);
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.give_rig_state(v1::RIG_FREE, 1);
  EXPECT_EQ(lab.trial_commands.size(), 1u);
  lab.give_rig_state(v1::RIG_FREE, 2);
  EXPECT_EQ(lab.trial_commands.size(), 2u);
}

TEST(Session, NamesTheVerdictOrReceiptThatDoesNotCome) {
  Lab lab(fate_of_attempt(1, {.has_verdict = false}));
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.run();
  lab.tick(2s);
  lab.run();
  lab.tick(2s);
  EXPECT_EQ(lab.machine().state().waiting_for(), "identification: verdict of trial 1");

  Lab other(fate_of_attempt(1, {.has_receipt = false}));
  other.command(v1::SESSION_START, "start", small_protocol());
  other.connect();
  other.run();
  other.tick(2s);
  other.run();
  other.tick(2s);
  EXPECT_EQ(other.machine().state().waiting_for(), "archive: receipt of trial 1");
  EXPECT_EQ(other.ledger().counted, 0u);
}

TEST(Session, LetsTheOperatorGiveATrialUpThatIsStuck) {
  Lab lab(fate_of_attempt(1, {.has_verdict = false}));
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  for (int i = 0; i < 3; ++i) {
    lab.run();
    lab.tick(2s);
  }
  ASSERT_EQ(lab.phase(), v1::SESSION_WAITING);
  lab.command(v1::SESSION_RESUME, "go");
  EXPECT_EQ(lab.ledger().rejected, 1u);
  EXPECT_TRUE(lab.run_to_end());
  expect_each_counted_once(lab, 8);
}

TEST(Session, TriesARefusedTrialAgainAndThenAsks) {
  Lab lab([](const v1::TrialProgram& program) {
    return program.attempt() <= 3 ? Fate{.end = v1::TRIAL_REFUSED, .detail = "trial 9 is running"} : Fate{};
  });
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.run();
  EXPECT_EQ(lab.phase(), v1::SESSION_WAITING);
  EXPECT_EQ(lab.machine().state().waiting_for(),
            "rig: refused a trial (trial 9 is running), which is tried again");
  lab.tick(500ms);
  lab.run();
  lab.tick(500ms);
  lab.run();
  EXPECT_EQ(lab.machine().state().waiting_for(),
            "operator: the rig refused a trial 3 times (trial 9 is running); resume tries again");
  EXPECT_FALSE(lab.machine().next_deadline().has_value());
  lab.command(v1::SESSION_RESUME, "go");
  EXPECT_TRUE(lab.run_to_end());
  expect_each_counted_once(lab, 8);
  EXPECT_EQ(lab.ledger().rejected, 0u);  // what never began is no rejection
  EXPECT_EQ(lab.trial_commands[3].program().planned_index(), 0u);
}

TEST(Session, CountsRefusalsAnewAfterEachHoldThatWasCleared) {
  Lab lab([](const v1::TrialProgram& program) {
    return program.attempt() <= 5 ? Fate{.end = v1::TRIAL_REFUSED, .detail = "overrun"} : Fate{};
  });
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  for (int refusal = 1; refusal <= 5; ++refusal) {
    lab.run();
    lab.give_rig_state(v1::RIG_HELD, 1, 1000 * refusal, "fault: overrun");
    lab.give_rig_state(v1::RIG_FREE, 1, 1000 * refusal + 500);
    lab.tick(500ms);
  }
  EXPECT_TRUE(lab.run_to_end()) << lab.machine().state().waiting_for();
  expect_each_counted_once(lab, 8);
}

TEST(Session, SetsARecordedTrialAsideThatIsNotValid) {
  Lab lab([](const v1::TrialProgram& program) { return Fate{.is_valid = program.planned_index() != 1}; });
  lab.command(
      v1::SESSION_START, "start",
      "schema = 1\nkind = \"recording\"\nname = \"r\"\n[[recording]]\nname = \"a\"\nplay = \"events\"\n"
      "events = 3\n");
  lab.connect();
  EXPECT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.phase(), v1::SESSION_COMPLETED);
  EXPECT_EQ(lab.ledger().counted, 2u);
  EXPECT_EQ(lab.ledger().set_aside, 1u);
  EXPECT_EQ(lab.trial_commands.size(), 3u);
}

TEST(Session, TriesARecordedTrialWithAGapOnceMore) {
  Lab lab([](const v1::TrialProgram& program) {
    return Fate{.is_valid = program.planned_index() != 1, .reason = v1::REASON_GAP};
  });
  lab.command(
      v1::SESSION_START, "start",
      "schema = 1\nkind = \"recording\"\nname = \"r\"\n[[recording]]\nname = \"a\"\nplay = \"events\"\n"
      "events = 3\n");
  lab.connect();
  EXPECT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.ledger().rejected, 2u);
  EXPECT_EQ(lab.ledger().set_aside, 1u);
  EXPECT_EQ(lab.ledger().counted, 2u);
}

TEST(Session, RepeatsARecordedTrialThatBrokeOff) {
  Lab lab(fate_of_attempt(2, {.end = v1::TRIAL_BROKEN_OFF}));
  lab.command(
      v1::SESSION_START, "start",
      "schema = 1\nkind = \"recording\"\nname = \"r\"\n[[recording]]\nname = \"a\"\nplay = \"events\"\n"
      "events = 3\n");
  lab.connect();
  EXPECT_TRUE(lab.run_to_end());
  expect_each_counted_once(lab, 3);
}

TEST(Session, CompletesOnlyWithTheReceiptsOfRejectedTrials) {
  Lab lab(fate_of_attempt(8, {.is_valid = false, .has_receipt = false}));
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.run();
  EXPECT_EQ(lab.phase(), v1::SESSION_COMPLETING);
  EXPECT_EQ(lab.machine().state().waiting_for(), "archive: receipts of 1 rejected trials");
  v1::ArchiveReceipt receipt;
  receipt.kind(v1::RECEIPT_TRIAL);
  receipt.subject_id(trial_id(Lab::kSession, 8));
  lab.take(lab.machine().on_receipt(receipt));
  EXPECT_EQ(lab.phase(), v1::SESSION_COMPLETED);
  EXPECT_EQ(lab.machine().state().message(), "8 trials counted");
}

TEST(Session, SaysSoWhereAReceiptOfARejectedTrialNeverComes) {
  Lab lab(fate_of_attempt(8, {.is_valid = false, .has_receipt = false}));
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  EXPECT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.machine().state().message(),
            "8 trials counted; the archive has not confirmed 1 rejected ones");
}

}  // namespace
}  // namespace tonus::scheduler
