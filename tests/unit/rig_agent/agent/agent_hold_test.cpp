// When the rig is held, what frees it, and who may move it.

#include <set>

#include "tests/unit/rig_agent/agent/agent_fixture.hpp"

namespace tonus::rig {
namespace {

class AgentHoldTest : public AgentTest {
 protected:
  /// The end of a trial that was commanded now.
  std::string refusal(std::uint32_t attempt) {
    EXPECT_TRUE(commands_->write(command(attempt)));
    const auto outcome = run_to_outcome();
    if (!outcome || outcome->end() != v1::TRIAL_REFUSED) return "";
    return outcome->detail();
  }
  void fault() {
    rig_->loop().emergency_stop();
    (void)ask(v1::RIG_ABORT_TRIAL);  // steps the simulated clock
    agent_->step();
  }
};

TEST_F(AgentHoldTest, RunsNoTrialForASessionThatItIsNotArmedFor) {
  start_agent(2000);
  EXPECT_EQ(refusal(1), "the rig is not armed for this session");
  lease_->arm(id_of("another session"), clock_.now());
  EXPECT_EQ(refusal(2), "the rig is not armed for this session");
}

TEST_F(AgentHoldTest, IsArmedBySomebodyWhoKnowsThisRunOfTheAgent) {
  start_agent(2000);
  v1::RigCommand arm;
  arm.request(v1::RIG_ARM);
  arm.session_id(kSession);
  arm.epoch(1000);
  EXPECT_FALSE(ask(arm).is_done());
  arm.epoch(2000);
  EXPECT_TRUE(ask(arm).is_done());
  EXPECT_EQ(state().mode(), v1::RIG_ARMED);
  EXPECT_EQ(state().session_id(), kSession);
  EXPECT_EQ(refusal(1), "");
}

TEST_F(AgentHoldTest, IsArmedForOneSessionAtATime) {
  v1::RigCommand arm;
  arm.request(v1::RIG_ARM);
  arm.session_id(id_of("another session"));
  arm.epoch(1000);
  EXPECT_FALSE(ask(arm).is_done());
  EXPECT_TRUE(ask(v1::RIG_DISARM).is_done());
  EXPECT_TRUE(ask(arm).is_done());
}

TEST_F(AgentHoldTest, CarriesOutARepeatedRequestOnce) {
  start_agent(2000);
  v1::RigCommand arm;
  arm.rig_id(rig_->names().id);
  arm.request_id(random_id());
  arm.request(v1::RIG_ARM);
  arm.session_id(kSession);
  arm.epoch(2000);
  ASSERT_TRUE(rig_commands_->write(arm));
  agent_->step();
  EXPECT_TRUE(ask(v1::RIG_DISARM).is_done());
  ASSERT_TRUE(rig_commands_->write(arm));  // late
  agent_->step();
  EXPECT_EQ(runtime::drain(*rig_replies_).size(), 1u) << "it is answered";
  EXPECT_EQ(lease_->session(), kNoId) << "and arms nothing";
}

TEST_F(AgentHoldTest, MovesNothingInTheFirstSecondAfterArming) {
  start_agent(2000, true);
  lease_->arm(kSession, clock_.now());
  EXPECT_EQ(refusal(1), "nothing moves in the first 1000 ms after the rig was armed");
}

TEST_F(AgentHoldTest, AFaultHoldsTheRigAcrossARestart) {
  fault();
  EXPECT_EQ(state().mode(), v1::RIG_HELD);
  EXPECT_EQ(state().held_because(), "fault: emergency_stop");
  start_armed(2000);
  EXPECT_EQ(refusal(1).substr(0, 28), "held: fault: emergency_stop;");
  EXPECT_FALSE(ask(v1::RIG_ARM).is_done());
}

TEST_F(AgentHoldTest, ClearingFreesTheRigAndArmsNothing) {
  fault();
  const auto cleared = ask(v1::RIG_CLEAR_FAULT);
  EXPECT_TRUE(cleared.is_done()) << cleared.message();
  agent_->step();
  EXPECT_EQ(state().mode(), v1::RIG_FREE);
  EXPECT_EQ(refusal(1), "the rig is not armed for this session");
  EXPECT_TRUE(ask(v1::RIG_ARM).is_done());
  EXPECT_EQ(refusal(2), "");
  start_armed(2000);
  EXPECT_NE(state().mode(), v1::RIG_HELD);
}

TEST_F(AgentHoldTest, ClearsOfOneHoldThatComeTogetherFreeTheRigAndAreAllAnswered) {
  fault();
  v1::RigCommand command;
  command.rig_id(rig_->names().id);
  command.request(v1::RIG_CLEAR_FAULT);
  command.hold_number(latch_->number());
  std::set<Id> asked;
  for (int i = 0; i < 3; ++i) {
    command.request_id(random_id());
    asked.insert(command.request_id());
    ASSERT_TRUE(rig_commands_->write(command));
  }
  for (int i = 0; i < 1000 && !asked.empty(); ++i) {
    agent_->step();
    for (const auto& received : runtime::drain(*rig_replies_)) {
      EXPECT_TRUE(received.value.is_done()) << received.value.message();
      asked.erase(received.value.request_id());
    }
  }
  EXPECT_TRUE(asked.empty());
  agent_->step();
  EXPECT_EQ(state().mode(), v1::RIG_FREE);
  EXPECT_EQ(rig_->loop().state().faults, 0U);
}

TEST_F(AgentHoldTest, AClearOfAnEarlierHoldLeavesALaterOne) {
  fault();
  v1::RigCommand late;
  late.request(v1::RIG_CLEAR_FAULT);
  late.hold_number(latch_->number());
  ASSERT_TRUE(ask(v1::RIG_CLEAR_FAULT).is_done());
  fault();
  const auto reply = ask(late);
  EXPECT_FALSE(reply.is_done());
  EXPECT_EQ(reply.message().substr(0, 38), "hold_number: 1 is not allowed; expecte") << reply.message();
  agent_->step();
  EXPECT_EQ(state().mode(), v1::RIG_HELD);
}

TEST_F(AgentHoldTest, AStopOnItsOwnTopicHoldsTheRigAndNamesWhoAsked) {
  stops_.add("the page");
  rig_->loop().emergency_stop();  // as the safety channel does first
  agent_->step();
  agent_->step();
  EXPECT_EQ(state().mode(), v1::RIG_HELD);
  EXPECT_NE(state().held_because().find("stop by the page"), std::string::npos) << state().held_because();
}

TEST_F(AgentHoldTest, AnAgentWhoseSchedulerFallsSilentInATrialEndsItAndHoldsTheRig) {
  start_armed(2000, true);
  std::int64_t now = 0;
  const auto cycle = [&] { rig_->loop().step(now += 1'000'000); };
  ASSERT_TRUE(commands_->write(command(1)));
  v1::RigLease lease;
  lease.rig_id(rig_->names().id);
  lease.session_id(kSession);
  lease.epoch(2000);
  const auto turn = [&] {
    agent_->step();
    cycle();
  };
  for (int i = 0; i < 2500; ++i) {
    if (i % 100 == 0) lease_->hear(lease, clock_.now());
    turn();
  }
  EXPECT_EQ(state().mode(), v1::RIG_IN_TRIAL);
  for (int i = 0; i < 1100; ++i) turn();  // more than the command time-out of 1 s by the loop's clock
  agent_->step();
  EXPECT_EQ(state().mode(), v1::RIG_HELD);
  EXPECT_EQ(state().held_because(), "fault: command_timeout");
}

TEST_F(AgentHoldTest, ALeaseOfAnotherSessionOrRunOfTheAgentIsNone) {
  start_armed(2000, true);
  const auto heard = *lease_->heard();
  v1::RigLease lease;
  lease.rig_id(rig_->names().id);
  lease.session_id(kSession);
  lease.epoch(1000);
  lease_->hear(lease, clock_.now());
  lease.epoch(2000);
  lease.session_id(id_of("another session"));
  lease_->hear(lease, clock_.now());
  EXPECT_EQ(*lease_->heard(), heard);
}

TEST_F(AgentHoldTest, AnArmedRigWhoseSchedulerFallsSilentIsDisarmed) {
  start_agent(2000, true);
  lease_->arm(kSession, clock_.now() - std::chrono::seconds(2));
  agent_->step();
  EXPECT_EQ(lease_->session(), kNoId);
  EXPECT_EQ(refusal(1), "the rig is not armed for this session");
}

TEST_F(AgentHoldTest, ARigThatMovesNothingRealMayGoOnByItselfButNotAfterAStop) {
  ASSERT_TRUE(latch_->set_powered(true));
  resumes_unattended_ = true;
  start_agent(2000);
  ASSERT_TRUE(latch_->is_held());
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (latch_->is_held() && std::chrono::steady_clock::now() < deadline) {
    agent_->step();
    rig_->loop().step(0);
  }
  EXPECT_FALSE(latch_->is_held());
  fault();
  for (int i = 0; i < 3; ++i) {
    agent_->step();
    rig_->loop().step(0);
  }
  EXPECT_TRUE(latch_->is_held());
}

}  // namespace
}  // namespace tonus::rig
