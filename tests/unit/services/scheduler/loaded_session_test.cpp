#include <chrono>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/scheduler/session_machine.hpp"
#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::scheduler {
namespace {

using ::testing::HasSubstr;
using testing::Lab;
using testing::small_loaded_protocol;
using namespace std::chrono_literals;

v1::Estimate estimate_of_set_one(std::array<double, 4> stiffness, std::vector<std::uint32_t> attempts) {
  v1::Estimate e;
  e.estimate_id(id_of("estimate"));
  e.session_id(Lab::kSession);
  e.posture_index(0);
  e.method("state_variable");
  e.model("linear");
  e.status(v1::ESTIMATE_OK);
  e.stiffness_N_per_m().value(stiffness);
  for (const auto attempt : attempts) {
    v1::TrialRange range;
    range.attempt(attempt);
    e.trials().push_back(range);
  }
  return e;
}

// K = Rot(30) diag(300, 100) Rot(30)', in closed form.
const std::array<double, 4> kTurnedBy30{250.0, 50.0 * std::sqrt(3.0), 50.0 * std::sqrt(3.0), 150.0};

TEST(LoadedSession, TakesTheBiasDirectionsFromSetOnesStiffness) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_loaded_protocol());
  lab.connect();
  lab.run();
  EXPECT_EQ(lab.ledger().counted, 2u);
  EXPECT_EQ(lab.phase(), v1::SESSION_WAITING);
  EXPECT_EQ(lab.machine().state().waiting_for(), "identification: set one's stiffness at 'near'");
  lab.take(lab.machine().on_estimate(
      estimate_of_set_one({100.0, 0.0, 0.0, 300.0}, {1})));  // without trial 2: too early
  EXPECT_EQ(lab.phase(), v1::SESSION_WAITING);
  lab.take(lab.machine().on_estimate(estimate_of_set_one(kTurnedBy30, {1, 2})));
  EXPECT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.phase(), v1::SESSION_COMPLETED);
  ASSERT_EQ(lab.trial_commands.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto& program = lab.trial_commands[i].program();
    const Eigen::Vector2d bias(program.bias_N()[0], program.bias_N()[1]);
    if (program.set_number() == 1) {
      EXPECT_EQ(bias, Eigen::Vector2d(0.0, 0.0));
      continue;
    }
    EXPECT_GE(bias.norm(), 0.7);
    EXPECT_LT(bias.norm(), 1.0);
    const Eigen::Vector2d direction =
        program.set_number() == 2  // +major at 30 deg, -minor opposite to -60 deg
            ? Eigen::Vector2d(std::sqrt(3.0) / 2.0, 0.5)
            : Eigen::Vector2d(-0.5, std::sqrt(3.0) / 2.0);
    EXPECT_TRUE(bias.normalized().isApprox(direction, 1e-9)) << bias.transpose();
    EXPECT_GE(program.bias_ramp_s(), 2.0);
    EXPECT_EQ(program.bias_hold_s(), 1.0);
  }
}

TEST(LoadedSession, AsksTheOperatorWhereTheStiffnessGivesNoAxes) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_loaded_protocol());
  lab.connect();
  lab.run();
  auto undetermined = estimate_of_set_one({0.0, 0.0, 0.0, 0.0}, {1, 2});
  undetermined.status(v1::ESTIMATE_UNDETERMINED);
  undetermined.reasons({"regressor without full rank"});
  lab.take(lab.machine().on_estimate(undetermined));
  EXPECT_EQ(lab.phase(), v1::SESSION_WAITING);
  EXPECT_EQ(lab.machine().state().waiting_for(),
            "operator: set one's stiffness at 'near' gives no axes for the bias: it is undetermined: "
            "regressor without "
            "full rank");
  lab.command(v1::SESSION_RESUME, "go");
  EXPECT_FALSE(lab.reply_to("go")->is_done());
  EXPECT_EQ(lab.trial_commands.size(), 2u);
  lab.take(lab.machine().on_estimate(estimate_of_set_one(kTurnedBy30, {1, 2})));
  EXPECT_TRUE(lab.run_to_end());
}

TEST(LoadedSession, TakesDoubtfulAxesIfTheOperatorSaysSo) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_loaded_protocol());
  lab.connect();
  lab.run();
  auto suspect = estimate_of_set_one(kTurnedBy30, {1, 2});
  suspect.status(v1::ESTIMATE_SUSPECT);
  lab.take(lab.machine().on_estimate(suspect));
  EXPECT_EQ(
      lab.machine().state().waiting_for(),
      "operator: set one's stiffness at 'near' gives doubtful axes for the bias: it is suspect; resume takes "
      "them");
  lab.command(v1::SESSION_RESUME, "go");
  EXPECT_TRUE(lab.reply_to("go")->is_done());
  EXPECT_TRUE(lab.run_to_end());
  EXPECT_EQ(lab.ledger().counted, 6u);
}

TEST(LoadedSession, AsksBeforeItUsesAnEstimateWithoutSomeOfItsTrials) {
  Lab lab;
  lab.command(v1::SESSION_START, "start", small_loaded_protocol());
  lab.connect();
  lab.run();
  lab.take(lab.machine().on_estimate(estimate_of_set_one(kTurnedBy30, {1})));
  ASSERT_TRUE(lab.machine().next_deadline().has_value());
  lab.tick(10s);
  EXPECT_THAT(lab.machine().state().waiting_for(),
              HasSubstr("it was made without 1 of its 2 trials; resume takes them"));
}

}  // namespace
}  // namespace tonus::scheduler
