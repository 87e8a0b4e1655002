#include "services/protocol/stop_rule.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "services/protocol/directions.hpp"
#include "services/protocol/plan.hpp"
#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::protocol {
namespace {

StopWhen rule_of(double stiffness, int least, int most) {
  StopWhen rule;
  rule.stiffness = stiffness;
  rule.trials_least = least;
  rule.trials_most = most;
  return rule;
}

Look look_of(std::size_t trials, double stiffness) { return {trials, stiffness, 0.1, 0.1, true, true}; }

std::string led_protocol(const std::string& keys) {
  std::string text = scheduler::testing::small_protocol();
  const std::string from = "directions = 2";
  text.replace(text.find(from), from.size(), "directions = 8");
  return text + "[stop_when]\n" + keys;
}

std::string refusal_of(const std::string& keys) {
  const auto protocol = parse_protocol(led_protocol(keys), "p.toml");
  return protocol ? "" : protocol.error().message;
}

TEST(StopRule, PredictsTheTrialsByTheirRoot) {
  const std::vector looks{look_of(8, 0.10)};
  const Ruling ruling = ruling_on(rule_of(0.05, 8, 64), looks);
  EXPECT_EQ(ruling.end, LookEnd::kGoesOn);
  EXPECT_NEAR(ruling.needed, 32.0, 1e-9);
  EXPECT_EQ(ruling.because, "");
}

TEST(StopRule, HoldsEachOfSeveralGoals) {
  StopWhen rule = rule_of(0.2, 8, 64);
  rule.mass = 0.05;
  EXPECT_FALSE(is_narrow(rule, look_of(8, 0.1)));
  rule.mass = 0.1;
  EXPECT_TRUE(is_narrow(rule, look_of(8, 0.1)));
}

TEST(StopRule, EndsNoConditionByAnEstimateThatIsNotOk) {
  Look suspect = look_of(9, 0.01);
  suspect.is_ok = false;
  EXPECT_EQ(ruling_on(rule_of(0.05, 8, 16), std::vector{suspect, suspect}).end, LookEnd::kGoesOn);
  suspect.trials = 16;
  const Ruling ruling = ruling_on(rule_of(0.05, 8, 16), std::vector{suspect, suspect});
  EXPECT_EQ(ruling.end, LookEnd::kOutOfTrials);
  EXPECT_EQ(ruling.because,
            "16 trials, the most allowed: half-width of stiffness 1 %, goal 5 %, but the estimate is not ok");
}

TEST(StopRule, GoesOnWithoutAnEstimate) {
  const Look none{9, std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0, false, false};
  EXPECT_EQ(ruling_on(rule_of(0.05, 8, 16), std::vector{look_of(8, 0.01), none}).end, LookEnd::kGoesOn);
  EXPECT_TRUE(std::isnan(ruling_on(rule_of(0.05, 8, 16), std::vector{none}).needed));
}

TEST(Directions, HaveTheStatedEntropyWhateverCameBefore) {
  Draws draws(5, 1);
  for (int run = 0; run < 2000; ++run) {
    std::vector<int> counts(8);
    for (int& count : counts) count = static_cast<int>(draws.below(4));
    const double entropy = draws.uniform(0.0, 3.0);
    EXPECT_GE(entropy_of(direction_chances(counts, entropy)), entropy - 1e-9);
  }
}

TEST(Directions, AreAPermutedBlockWithoutEntropyAndWithoutMemoryWithAllOfIt) {
  const std::vector<int> counts{1, 1, 0, 1};
  EXPECT_NEAR(direction_chances(counts, 0.0)[2], 1.0, 1e-12);
  for (const double chance : direction_chances(counts, 2.0)) EXPECT_NEAR(chance, 0.25, 1e-6);
}

TEST(Directions, StayBalancedWithOneBit) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    std::vector<int> counts(8, 0);
    for (std::uint64_t n = 0; n < 64; ++n) {
      Draws draws(seed, n);
      ++counts[draw_by(direction_chances(counts, 1.0), draws)];
    }
    // Without memory the counts scatter by the root of 7.
    for (const int count : counts) EXPECT_NEAR(count, 8, 3);
  }
}

TEST(StopWhenKeys, AreReadWithTheirDefaults) {
  const auto protocol = parse_protocol(led_protocol("stiffness = 0.04\nmass = 0.1\n"), "p.toml");
  ASSERT_TRUE(protocol.has_value()) << protocol.error().message;
  ASSERT_TRUE(protocol->stop_when.has_value());
  EXPECT_EQ(protocol->stop_when->stiffness, 0.04);
  EXPECT_EQ(protocol->stop_when->mass, 0.1);
  EXPECT_FALSE(protocol->stop_when->damping.has_value());
  EXPECT_EQ(protocol->stop_when->method, "refined");
  EXPECT_EQ(protocol->stop_when->trials_least, 8);
  EXPECT_EQ(protocol->stop_when->trials_most, 16);
  EXPECT_EQ(protocol->stop_when->amplitude_most, 0.005);
  EXPECT_EQ(protocol->stop_when->rise_least, 0.2);
}

TEST(StopWhenKeys, AreRefusedOutsideTheirLimits) {
  EXPECT_EQ(refusal_of("stiffness = 2.0\n"),
            "p.toml:19: stop_when.stiffness: 2 is not allowed; expected 0.001 to 1");
  EXPECT_EQ(refusal_of("stiffness = 0.05\ntrials_most = 17\n"),
            "p.toml:20: stop_when.trials_most: 17 is not allowed; expected at most the 16 trials that "
            "perturbation plans for a condition");
  EXPECT_EQ(refusal_of("stiffness = 0.05\ntrials_least = 16\n"),
            "p.toml:20: stop_when.trials_least: 16 is not allowed; expected less than the most, 16");
  EXPECT_EQ(refusal_of("stiffness = 0.05\namplitude_most_m = 0.004\n"),
            "p.toml:20: stop_when.amplitude_most_m: 0.004 is not allowed; expected at least amplitude_m, "
            "0.005 m");
  EXPECT_EQ(refusal_of("stiffness = 0.05\nentropy_bits = 3.5\n"),
            "p.toml:20: stop_when.entropy_bits: 3.5 is not allowed; expected 0 to 3, what 8 directions have");
}

TEST(StopWhenPlan, HasTheMostTrialsOfEachConditionAndNoMore) {
  const auto protocol = parse_protocol(led_protocol("stiffness = 0.05\ntrials_most = 12\n"), "p.toml");
  ASSERT_TRUE(protocol.has_value()) << protocol.error().message;
  const Plan plan = build_plan(*protocol, 3);
  EXPECT_EQ(plan.trials.size(), 24U);
  ASSERT_EQ(plan.conditions.size(), 2U);
  EXPECT_EQ(plan.conditions[1].trials, 12U);
  EXPECT_EQ(plan.blocks[3].order.size(), 4U);
  EXPECT_EQ(plan.blocks[3].condition, 1U);
  for (const auto& trial : plan.trials)
    EXPECT_EQ(trial.program.direction_deg(),
              45.0 * static_cast<double>(direction_of(*protocol, trial.program)));
}

}  // namespace
}  // namespace tonus::protocol
