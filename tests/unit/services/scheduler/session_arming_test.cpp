// A rig with a person at it: what it takes before anything moves again.

#include <gtest/gtest.h>

#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::scheduler {
namespace {

using namespace std::chrono_literals;
using testing::Fate;
using testing::Lab;
using testing::small_protocol;

std::unique_ptr<Lab> attended(Lab::Script script = [](const v1::TrialProgram&) { return Fate{}; }) {
  auto lab = std::make_unique<Lab>(std::move(script));
  lab->is_attended = true;
  return lab;
}

std::unique_ptr<Lab> in_first_trial() {
  auto lab = attended();
  lab->is_mute = true;
  lab->command(v1::SESSION_START, "start", small_protocol());
  lab->connect();
  EXPECT_EQ(lab->trial_commands.size(), 1u);
  return lab;
}

TEST(Arming, FollowsTheOperatorsStartAndPrecedesTheFirstTrial) {
  const auto lab = in_first_trial();
  ASSERT_EQ(lab->armings.size(), 1u);
  EXPECT_EQ(lab->armings[0].request(), v1::RIG_ARM);
  EXPECT_EQ(lab->armings[0].session_id(), Lab::kSession);
  EXPECT_EQ(lab->armings[0].epoch(), 1u);
  ASSERT_TRUE(lab->machine().lease());
  EXPECT_EQ(lab->machine().lease()->session_id(), Lab::kSession);
}

TEST(Arming, IsGivenUpAtTheEndOfTheSession) {
  const auto lab = attended();
  lab->command(v1::SESSION_START, "start", small_protocol());
  lab->connect();
  EXPECT_TRUE(lab->run_to_end());
  EXPECT_EQ(lab->armings.back().request(), v1::RIG_DISARM);
  EXPECT_FALSE(lab->machine().lease());
}

TEST(Arming, WaitsASecondBeforeTheFirstTrialOfARigInRealTime) {
  const auto lab = attended();
  v1::RigState state;
  state.rig_id(testing::description_of_rig().rig_id());
  state.epoch(1);
  state.mode(v1::RIG_FREE);
  state.is_realtime_paced(true);
  lab->has_rig_state = true;
  lab->take(lab->machine().on_rig_state(state));
  lab->command(v1::SESSION_START, "start", small_protocol());
  lab->connect();
  lab->tick(1000ms);
  EXPECT_TRUE(lab->trial_commands.empty());
  lab->tick(50ms);
  EXPECT_EQ(lab->trial_commands.size(), 1u);
}

TEST(Arming, OfARestartedRigNeedsTheOperatorsResume) {
  const auto lab = in_first_trial();
  lab->give_rig_state(v1::RIG_FREE, 2);
  for (int i = 0; i < 20; ++i) lab->tick(2s);
  EXPECT_EQ(lab->trial_commands.size(), 1u);
  EXPECT_FALSE(lab->machine().lease());
  EXPECT_EQ(lab->phase(), v1::SESSION_WAITING);
  EXPECT_EQ(lab->machine().state().waiting_for(), "operator: resume (the rig agent was restarted)");
  lab->is_mute = false;
  lab->command(v1::SESSION_RESUME, "resume");
  EXPECT_TRUE(lab->reply_to("resume")->is_done());
  EXPECT_EQ(lab->armings.back().epoch(), 2u);
  EXPECT_TRUE(lab->run_to_end());
}

TEST(Arming, ByARestartedSchedulerNeedsTheOperatorsResume) {
  const auto lab = in_first_trial();
  lab->restart_machine();
  lab->connect();
  for (int i = 0; i < 20; ++i) lab->tick(2s);
  EXPECT_EQ(lab->trial_commands.size(), 1u);
  EXPECT_EQ(lab->armings.size(), 1u);
  EXPECT_EQ(lab->machine().state().waiting_for(), "operator: resume (the scheduler was restarted)");
  lab->is_mute = false;
  lab->command(v1::SESSION_RESUME, "resume");
  EXPECT_TRUE(lab->run_to_end());
  EXPECT_EQ(lab->phase(), v1::SESSION_COMPLETED);
}

TEST(Arming, OfARigThatHasDisarmedItselfNeedsTheOperatorsResume) {
  const auto lab = attended([](const v1::TrialProgram& program) {
    return program.attempt() == 1 ? Fate{.has_receipt = false} : Fate{};
  });
  lab->command(v1::SESSION_START, "start", small_protocol());
  lab->connect();
  lab->give_rig_state(v1::RIG_FREE, 1, 900);  // sent before the arming, at 1000
  EXPECT_TRUE(lab->machine().lease());
  lab->give_rig_state(v1::RIG_FREE, 1, 2000);
  EXPECT_FALSE(lab->machine().lease());
  lab->run();
  EXPECT_EQ(lab->trial_commands.size(), 1u);
}

TEST(Arming, OfAHeldRigNeedsAClearAndThenAResume) {
  const auto lab = in_first_trial();
  lab->give_rig_state(v1::RIG_HELD, 1, 2000, "fault: force");
  EXPECT_EQ(lab->machine().state().waiting_for(),
            "operator: the rig is held (fault: force); when it is safe, clear it, then resume");
  lab->command(v1::SESSION_RESUME, "too early");
  EXPECT_FALSE(lab->reply_to("too early")->is_done());
  lab->give_rig_state(v1::RIG_FREE, 1, 3000);  // cleared
  for (int i = 0; i < 20; ++i) lab->tick(2s);
  EXPECT_EQ(lab->trial_commands.size(), 1u) << "clearing is not resuming";
  lab->is_mute = false;
  lab->command(v1::SESSION_RESUME, "resume");
  EXPECT_TRUE(lab->reply_to("resume")->is_done());
  EXPECT_TRUE(lab->run_to_end());
}

TEST(Arming, OfAPausedSessionWhoseRigIsHeldAsksForTheClearFirst) {
  const auto lab = attended();
  lab->command(v1::SESSION_START, "start", small_protocol());
  lab->connect();
  lab->command(v1::SESSION_PAUSE, "pause");
  lab->run();
  ASSERT_EQ(lab->phase(), v1::SESSION_PAUSED);
  EXPECT_EQ(lab->machine().state().waiting_for(), "operator: resume");
  lab->give_rig_state(v1::RIG_HELD, 1, 2000, "fault: force");
  EXPECT_EQ(lab->phase(), v1::SESSION_PAUSED);
  EXPECT_EQ(lab->machine().state().waiting_for(),
            "operator: the rig is held (fault: force); when it is safe, clear it, then resume")
      << "a resume alone is refused";
}

TEST(Arming, IsNotTakenFromAResumeThatCameBeforeTheHold) {
  const auto lab = in_first_trial();
  lab->command(v1::SESSION_PAUSE, "pause");
  lab->command(v1::SESSION_RESUME, "resume");
  lab->give_rig_state(v1::RIG_HELD, 1, 2000, "stop by command line");
  lab->give_rig_state(v1::RIG_FREE, 1, 3000);
  for (int i = 0; i < 20; ++i) lab->tick(2s);
  EXPECT_EQ(lab->trial_commands.size(), 1u);
  EXPECT_EQ(lab->machine().state().waiting_for(), "operator: resume (stop by command line)");
}

TEST(Arming, OfARigThatStatesThatItMovesNothingRealNeedsNobody) {
  Lab lab;
  lab.is_mute = true;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.give_rig_state(v1::RIG_FREE, 2);
  EXPECT_EQ(lab.trial_commands.size(), 2u);
}

TEST(Arming, ThatTheRigRefusesIsAskedForAgainAndItsReasonShown) {
  const auto lab = attended();
  lab->command(v1::SESSION_START, "start", small_protocol());
  v1::RigReply refusal;
  auto& machine = lab->machine();
  (void)machine.on_rig_description(testing::description_of_rig());
  (void)machine.on_roster("");
  v1::RigState state;
  state.epoch(1);
  state.mode(v1::RIG_FREE);
  const auto effects = machine.on_rig_state(state);
  for (const auto& message : effects.messages) {
    if (const auto* arm = std::get_if<v1::RigCommand>(&message)) refusal.request_id(arm->request_id());
  }
  refusal.message("trial 3 is running");
  (void)machine.on_rig_reply(refusal);
  EXPECT_EQ(machine.state().waiting_for(), "rig: is not armed: trial 3 is running");
  EXPECT_TRUE(lab->trial_commands.empty());
  lab->tick(500ms);
  EXPECT_EQ(lab->trial_commands.size(), 1u);
}

}  // namespace
}  // namespace tonus::scheduler
