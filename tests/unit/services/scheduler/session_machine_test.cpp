#include "services/scheduler/session_machine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::scheduler {
namespace {

using testing::counted_trials;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Lab;
using testing::small_protocol;

/// Each planned trial of `count` is counted once.
void expect_each_counted_once(const Lab& lab, std::uint32_t count) {
  const auto counted = counted_trials(lab.records);
  EXPECT_EQ(counted.size(), count);
  for (const auto& [planned, times] : counted) EXPECT_EQ(times, 1) << "planned trial " << planned;
}

std::vector<v1::SessionPhase> phases(const Lab& lab) {
  std::vector<v1::SessionPhase> all;
  for (const auto& state : lab.states) {
    if (all.empty() || all.back() != state.phase()) all.push_back(state.phase());
  }
  return all;
}

TEST(Session, GoesThroughItsPhasesAndCountsEveryPlannedTrialOnce) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  EXPECT_EQ(lab.phase(), v1::SESSION_PREPARING);
  EXPECT_EQ(lab.machine().state().waiting_for(), "services: nothing is known yet");
  EXPECT_TRUE(lab.reply_to("start")->is_done());
  EXPECT_THAT(lab.reply_to("start")->message(), HasSubstr("8 trials planned, about 1."));
  lab.connect();
  EXPECT_TRUE(lab.run_to_end());
  EXPECT_THAT(phases(lab), ElementsAre(v1::SESSION_PREPARING, v1::SESSION_READY, v1::SESSION_RUNNING,
                                       v1::SESSION_COMPLETING, v1::SESSION_COMPLETED));
  expect_each_counted_once(lab, 8);
  EXPECT_EQ(lab.trial_commands.size(), 8u);
  EXPECT_EQ(lab.machine().state().message(), "8 trials counted");
  EXPECT_EQ(lab.machine().state().attempts(), 8u);
  EXPECT_EQ(lab.machine().state().counted(), 8u);
  EXPECT_EQ(lab.machine().state().experiment_s(), 80.0);  // 2000 samples at 200 Hz each
  EXPECT_EQ(lab.machine().state().remaining_s(), 0.0);
}

TEST(Session, RunsOneTrialAtATimeInTheOrderOfThePlan) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  for (std::uint32_t n = 1; n <= 8; ++n) {
    ASSERT_EQ(lab.trial_commands.size(), n);
    EXPECT_EQ(lab.trial_commands.back().program().planned_index(), n - 1);
    EXPECT_EQ(lab.trial_commands.back().trial_id(), trial_id(Lab::kSession, n));
    for (int message = 0; message < 3; ++message) lab.step();  // outcome, verdict, receipt
  }
}

TEST(Session, RecordsACommandBeforeItIsSentAndACountBeforeTheNext) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  std::uint32_t commanded = 0, counted = 0;
  for (const Record& entry : lab.records) {
    if (std::holds_alternative<record::Commanded>(entry)) {
      EXPECT_EQ(commanded, counted);
      ++commanded;
    }
    if (std::holds_alternative<record::Counted>(entry)) ++counted;
  }
  lab.run();
  EXPECT_EQ(lab.ledger().counted, 8u);
}

TEST(Session, PublishesThePlanAndTheBoundRig) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  ASSERT_EQ(lab.plans.size(), 2u);
  EXPECT_EQ(lab.plans[0].rig_id(), kNoId);
  EXPECT_EQ(lab.plans[1].rig_id(), id_of("rig/test"));
  EXPECT_EQ(lab.plans[1].planned_trials(), 8u);
  EXPECT_EQ(lab.plans[1].protocol_toml(), small_protocol());
  EXPECT_EQ(lab.plans[1].seed(), 7u);
  EXPECT_EQ(lab.plans[1].subject(), "s01");
  ASSERT_EQ(lab.plans[1].postures().size(), 2u);
  EXPECT_EQ(lab.plans[1].postures()[0].trials(), 4u);
}

TEST(Session, CuesChangeWithThePostureOnly) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.connect();
  lab.run();
  ASSERT_EQ(lab.cues.size(), 2u);
  EXPECT_EQ(lab.cues[0].target_m(), (std::array<double, 2>{0.0, 0.24}));
  EXPECT_EQ(lab.cues[1].target_m(), (std::array<double, 2>{0.0, 0.52}));
  EXPECT_EQ(lab.cues[0].target_diameter_m(), 0.010);
}

TEST(Session, CuesCarryTheInstruction) {
  auto text = small_protocol();
  text.replace(text.find("unloaded"), 8, "instruction");
  text +=
      "[[instruction]]\nname = \"relax\"\ntext = \"Relax.\"\n[[instruction]]\nname = \"stiffen_x\"\ntext = "
      "\"Stiffen.\"\n";
  Lab lab;
  lab.command(v1::SESSION_START, "start", text);
  lab.connect();
  EXPECT_TRUE(lab.run_to_end());
  std::vector<std::string> instructions;
  for (const auto& cue : lab.cues) instructions.push_back(cue.instruction());
  EXPECT_THAT(instructions, ElementsAre("Relax.", "Stiffen.", "Relax.", "Stiffen."));
  EXPECT_EQ(lab.trial_commands[0].program().instruction(), "relax");
  EXPECT_EQ(lab.trial_commands[4].program().instruction(), "stiffen_x");
}

TEST(Session, NamesWhatTheRosterMissesAndGoesOnWhenItIsBack) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  lab.take(lab.machine().on_rig_description(testing::description_of_rig()));
  lab.give_rig_state(v1::RIG_FREE);
  lab.take(lab.machine().on_roster("archive is not there"));
  EXPECT_EQ(lab.phase(), v1::SESSION_PREPARING);
  EXPECT_EQ(lab.machine().state().waiting_for(), "archive is not there");
  lab.take(lab.machine().on_roster(""));
  for (int i = 0; i < 3; ++i) lab.step();
  lab.take(lab.machine().on_roster("identification is not there"));
  lab.run();
  EXPECT_EQ(lab.phase(), v1::SESSION_WAITING);
  EXPECT_EQ(lab.machine().state().waiting_for(), "identification is not there");
  EXPECT_EQ(lab.ledger().counted, 2u);  // the trial that ran was finished
  lab.take(lab.machine().on_roster(""));
  EXPECT_TRUE(lab.run_to_end());
}

TEST(Session, FailsWhereTheRigCannotRunTheProtocol) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  auto description = testing::description_of_rig();
  description.home_m({0.625, 0.0});
  lab.take(lab.machine().on_rig_description(description));
  lab.take(lab.machine().on_roster(""));
  EXPECT_EQ(lab.phase(), v1::SESSION_FAILED);
  EXPECT_THAT(lab.machine().state().message(), HasSubstr("protocol:14: perturbation.amplitude_m: 0.005"));
  EXPECT_TRUE(lab.trial_commands.empty());
}

TEST(Session, AsksTheOperatorForEachPostureWhereTheProtocolSaysSo) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol("confirm_posture = true\n"));
  lab.connect();
  EXPECT_EQ(lab.phase(), v1::SESSION_WAITING);
  EXPECT_EQ(
      lab.machine().state().waiting_for(),
      "operator: bring the subject's hand to posture 'near', (0.000, 0.240) m from the shoulder, and resume");
  EXPECT_EQ(lab.cues.size(), 1u);  // the subject sees where to go
  lab.command(v1::SESSION_RESUME, "1");
  lab.run();
  EXPECT_EQ(lab.phase(), v1::SESSION_WAITING);
  EXPECT_EQ(lab.ledger().counted, 4u);
  EXPECT_THAT(lab.machine().state().waiting_for(), HasSubstr("'far'"));
  lab.command(v1::SESSION_RESUME, "2");
  EXPECT_TRUE(lab.run_to_end());
}

TEST(Session, EstimatesTheRemainingTimeAtThePaceSoFar) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_protocol());
  double planned = 0.0;
  for (const auto& trial : lab.ledger().plan.trials) planned += trial.duration;
  EXPECT_NEAR(lab.states.back().remaining_s(), planned, 1e-9);
  lab.connect();
  ASSERT_TRUE(lab.run_until([&] { return lab.ledger().counted == 4; }));
  double done = 0.0;
  for (std::size_t i = 0; i < 4; ++i) done += lab.ledger().plan.trials[i].duration;
  EXPECT_NEAR(lab.states.back().remaining_s(), (planned - done) * 40.0 / done, 1e-9);  // 10 s each so far
}

}  // namespace
}  // namespace tonus::scheduler
