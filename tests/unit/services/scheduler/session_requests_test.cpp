#include <algorithm>
#include <chrono>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/contract/subject.hpp"
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

/// A session whose first trial is under way at the rig, which does not say more.
std::unique_ptr<Lab> running() {
  auto lab = std::make_unique<Lab>();
  lab->is_mute = true;
  lab->command(v1::SESSION_START, "start", small_protocol());
  lab->connect();
  EXPECT_EQ(lab->phase(), v1::SESSION_RUNNING);
  return lab;
}

/// The rig is heard again: its command is repeated and answered.
void unmute(Lab& lab) {
  lab.is_mute = false;
  lab.tick(2s);
}

TEST(Start, RefusesABadProtocolWithItsLineInTheReply) {
  Lab lab;
  auto text = small_protocol();
  text.replace(text.find("0.005"), 5, "0.5  ");
  lab.command(v1::SESSION_START, "start", text);
  ASSERT_NE(lab.reply_to("start"), nullptr);
  EXPECT_FALSE(lab.reply_to("start")->is_done());
  EXPECT_EQ(lab.reply_to("start")->message(),
            "protocol:14: perturbation.amplitude_m: 0.5 is not allowed; expected 0.0005 to 0.03 m");
  EXPECT_TRUE(lab.records.empty());
  EXPECT_FALSE(lab.machine().is_active());
}

TEST(Start, RefusesWhatTheKnownRigCannotRun) {
  Lab lab;
  auto description = testing::description_of_rig();
  description.home_m({0.625, 0.0});
  lab.take(lab.machine().on_rig_description(description));
  lab.command(v1::SESSION_START, "start", small_protocol());
  EXPECT_THAT(lab.reply_to("start")->message(), HasSubstr("rig 'test' reaches 0.070 to 0.630 m"));
  EXPECT_TRUE(lab.records.empty());
}

TEST(Start, RefusesAStudyAndASecondSession) {
  Lab lab;
  lab.command(
      v1::SESSION_START, "study",
      "schema = 1\nkind = \"study\"\nname = \"s\"\n[[subject]]\nname = \"a\"\nunloaded = \"u.toml\"\n");
  EXPECT_EQ(lab.reply_to("study")->message(),
            "protocol:2: kind: \"study\" is not allowed; expected a protocol of one session");
  lab.command(v1::SESSION_START, "first", small_protocol());
  lab.command(v1::SESSION_START, "second", small_protocol());
  EXPECT_TRUE(lab.reply_to("first")->is_done());
  EXPECT_FALSE(lab.reply_to("second")->is_done());
  EXPECT_EQ(lab.reply_to("second")->message(),
            "session " + to_hex(Lab::kSession) + " is preparing: one session runs at a time");
}

TEST(Start, BeginsANewSessionAfterTheLast) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  ASSERT_TRUE(lab.run_to_end());
  lab.command(v1::SESSION_START, "same", small_protocol());
  EXPECT_EQ(lab.reply_to("same")->message(),
            "session " + to_hex(Lab::kSession) + " has been: a new session needs a new id");
  v1::SessionCommand next;
  next.session_id(id_of("next"));
  next.request_id(id_of("next"));
  next.request(v1::SESSION_START);
  next.protocol_toml(small_protocol());
  next.subject("s02");
  next.subject_facts(contract::unknown_subject());
  lab.take(lab.machine().on_command(next));
  EXPECT_TRUE(lab.reply_to("next")->is_done());
  EXPECT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.machine().state().session_id(), id_of("next"));
  EXPECT_EQ(lab.machine().state().counted(), 8u);
}

TEST(Requests, AreNotExecutedTwice) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.command(v1::SESSION_START, "start", small_protocol());
  EXPECT_EQ(lab.replies.size(), 2u);
  EXPECT_EQ(lab.replies[0], lab.replies[1]);
  EXPECT_EQ(std::count_if(lab.records.begin(), lab.records.end(),
                          [](const auto& r) { return std::holds_alternative<record::Started>(r); }),
            1);
  lab.connect();
  lab.command(v1::SESSION_PAUSE, "pause");
  lab.run();
  lab.command(v1::SESSION_RESUME, "resume");
  ASSERT_EQ(lab.phase(), v1::SESSION_RUNNING);
  lab.command(v1::SESSION_PAUSE, "pause");  // delivered once more: answered again, nothing else
  EXPECT_EQ(lab.phase(), v1::SESSION_RUNNING);
  EXPECT_EQ(lab.reply_to("pause")->message(), "paused");
}

TEST(Requests, WithoutIdOrForAnotherSessionAreRefused) {
  Lab lab;
  v1::SessionCommand command;
  command.request(v1::SESSION_PAUSE);
  lab.take(lab.machine().on_command(command));
  EXPECT_EQ(lab.replies.back().message(), "a request needs an id that is not zero");
  command.request_id(id_of("a"));
  lab.take(lab.machine().on_command(command));
  EXPECT_EQ(lab.replies.back().message(), "there is no session");
  lab.command(v1::SESSION_START, "start", small_protocol());
  command.request_id(id_of("b"));
  command.session_id(id_of("another"));
  lab.take(lab.machine().on_command(command));
  EXPECT_EQ(lab.replies.back().message(), "there is no session " + to_hex(id_of("another")));
}

TEST(Pause, FinishesTheRunningTrialFirstAndIsAnsweredThen) {
  const auto lab = running();
  lab->command(v1::SESSION_PAUSE, "pause");
  EXPECT_EQ(lab->phase(), v1::SESSION_PAUSING);
  EXPECT_EQ(lab->reply_to("pause"), nullptr);
  lab->command(v1::SESSION_PAUSE, "pause");  // while its answer is still to come
  EXPECT_EQ(lab->reply_to("pause"), nullptr);
  unmute(*lab);
  lab->run();
  EXPECT_EQ(lab->phase(), v1::SESSION_PAUSED);
  EXPECT_EQ(lab->ledger().counted, 1u);
  ASSERT_NE(lab->reply_to("pause"), nullptr);
  EXPECT_TRUE(lab->reply_to("pause")->is_done());
  EXPECT_EQ(std::count_if(lab->replies.begin(), lab->replies.end(),
                          [](const auto& r) { return r.request_id() == id_of("pause"); }),
            1);
  EXPECT_FALSE(lab->machine().next_deadline().has_value());
}

TEST(Pause, TakesEffectAtOnceWhereNoTrialRuns) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.command(v1::SESSION_PAUSE, "pause");
  EXPECT_EQ(lab.phase(), v1::SESSION_PAUSED);
  EXPECT_TRUE(lab.reply_to("pause")->is_done());
  lab.connect();
  EXPECT_TRUE(lab.trial_commands.empty());
  lab.command(v1::SESSION_PAUSE, "again");
  EXPECT_TRUE(lab.reply_to("again")->is_done());
  lab.command(v1::SESSION_RESUME, "resume");
  EXPECT_EQ(lab.reply_to("resume")->message(), "preparing: waiting for rig: to be armed");
  EXPECT_TRUE(lab.run_to_end());
}

TEST(Resume, BeforeThePauseTookEffectCancelsIt) {
  const auto lab = running();
  lab->command(v1::SESSION_PAUSE, "pause");
  lab->command(v1::SESSION_RESUME, "resume");
  EXPECT_EQ(lab->phase(), v1::SESSION_RUNNING);
  EXPECT_FALSE(lab->reply_to("pause")->is_done());
  EXPECT_TRUE(lab->reply_to("resume")->is_done());
}

TEST(Resume, SaysWhatIsMissingWhereItCannotHelp) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.take(lab.machine().on_roster("rig is not there"));
  lab.command(v1::SESSION_RESUME, "resume");
  EXPECT_FALSE(lab.reply_to("resume")->is_done());
  EXPECT_EQ(lab.reply_to("resume")->message(), "preparing: waiting for rig is not there");
}

TEST(Abort, StopsTheRunningTrialBeforeAnythingIsWritten) {
  const auto lab = running();
  v1::SessionCommand abort;
  abort.session_id(Lab::kSession);
  abort.request_id(id_of("abort"));
  abort.request(v1::SESSION_ABORT);
  auto effects = lab->machine().on_command(abort);
  ASSERT_EQ(effects.urgent.size(), 1u);
  const auto& command = std::get<v1::RigCommand>(effects.urgent[0]);
  EXPECT_EQ(command.request(), v1::RIG_ABORT_TRIAL);
  EXPECT_EQ(command.trial_id(), trial_id(Lab::kSession, 1));
  EXPECT_EQ(command.rig_id(), id_of("rig/test"));
  lab->take(std::move(effects));
  EXPECT_EQ(lab->reply_to("abort"), nullptr);
  EXPECT_EQ(lab->machine().state().waiting_for(), "rig: to end trial 1");
  lab->run();  // the rig's reply
  EXPECT_EQ(lab->phase(), v1::SESSION_ABORTED);
  EXPECT_TRUE(lab->reply_to("abort")->is_done());
}

TEST(Abort, IsDoneWithTheOutcomeToo) {
  const auto lab = running();
  lab->rig_answers_aborts = false;
  lab->command(v1::SESSION_ABORT, "abort");
  v1::TrialOutcome outcome;
  outcome.trial_id(trial_id(Lab::kSession, 1));
  outcome.end(v1::TRIAL_ABORTED);
  lab->take(lab->machine().on_outcome(outcome));
  EXPECT_EQ(lab->phase(), v1::SESSION_ABORTED);
}

TEST(Abort, IsRepeatedUntilTheRigAnswersOrPatienceEnds) {
  const auto lab = running();
  lab->rig_answers_aborts = false;
  lab->command(v1::SESSION_ABORT, "abort");
  for (int i = 0; i < 9; ++i) lab->tick(500ms);
  EXPECT_EQ(lab->rig_commands.size(), 10u);
  EXPECT_EQ(lab->trial_commands.size(), 1u);  // never the trial
  lab->tick(500ms);
  EXPECT_EQ(lab->phase(), v1::SESSION_ABORTED);
  EXPECT_EQ(lab->machine().state().message(),
            "aborted by request; the rig has not confirmed that its trial ended");
}

/// Brings a lab into each phase from which an abort has to work without a trial running.
struct Place {
  const char* name;
  void (*arrange)(Lab&);
  v1::SessionPhase phase;
};

class AbortFrom : public ::testing::TestWithParam<Place> {};

TEST_P(AbortFrom, EndsTheSessionAtOnce) {
  Lab lab;
  GetParam().arrange(lab);
  ASSERT_EQ(lab.phase(), GetParam().phase);
  lab.command(v1::SESSION_ABORT, "abort");
  EXPECT_EQ(lab.phase(), v1::SESSION_ABORTED);
  EXPECT_TRUE(lab.reply_to("abort")->is_done());
  EXPECT_FALSE(lab.machine().next_deadline().has_value());
  lab.command(v1::SESSION_ABORT, "once more");
  EXPECT_TRUE(lab.reply_to("once more")->is_done());
  lab.command(v1::SESSION_RESUME, "resume");
  EXPECT_FALSE(lab.reply_to("resume")->is_done());
  EXPECT_EQ(lab.reply_to("resume")->message(), "the session has aborted: aborted by request");
}

INSTANTIATE_TEST_SUITE_P(
    Session, AbortFrom,
    ::testing::Values(Place{"Preparing",
                            [](Lab& lab) { lab.command(v1::SESSION_START, "s", small_protocol()); },
                            v1::SESSION_PREPARING},
                      Place{"Paused",
                            [](Lab& lab) {
                              lab.command(v1::SESSION_START, "s", small_protocol());
                              lab.command(v1::SESSION_PAUSE, "p");
                            },
                            v1::SESSION_PAUSED},
                      Place{"Waiting",
                            [](Lab& lab) {
                              lab.command(v1::SESSION_START, "s", small_protocol("confirm_posture = true\n"));
                              lab.connect();
                            },
                            v1::SESSION_WAITING},
                      Place{"Completing",
                            [](Lab& lab) {
                              lab.set_script([](const v1::TrialProgram& p) {
                                return p.attempt() == 1 ? Fate{.is_valid = false, .has_receipt = false}
                                                        : Fate{};
                              });
                              lab.command(v1::SESSION_START, "s", small_protocol());
                              lab.connect();
                              lab.run();
                            },
                            v1::SESSION_COMPLETING}),
    [](const auto& param) { return std::string(param.param.name); });

TEST(Abort, WhilePausingAnswersBoth) {
  const auto lab = running();
  lab->command(v1::SESSION_PAUSE, "pause");
  lab->command(v1::SESSION_ABORT, "abort");
  EXPECT_FALSE(lab->reply_to("pause")->is_done());
  lab->run();
  EXPECT_EQ(lab->phase(), v1::SESSION_ABORTED);
  EXPECT_TRUE(lab->reply_to("abort")->is_done());
}

TEST(Abort, AfterTheEndIsRefused) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  ASSERT_TRUE(lab.run_to_end());
  lab.command(v1::SESSION_ABORT, "abort");
  EXPECT_FALSE(lab.reply_to("abort")->is_done());
  EXPECT_EQ(lab.reply_to("abort")->message(), "the session has completed: 8 trials counted");
}

}  // namespace
}  // namespace tonus::scheduler
