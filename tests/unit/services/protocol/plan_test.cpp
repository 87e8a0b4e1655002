#include "services/protocol/plan.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "services/protocol/draws.hpp"
#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::protocol {
namespace {

Protocol protocol_of(const std::string& text) {
  auto protocol = parse_protocol(text, "p.toml");
  EXPECT_TRUE(protocol.has_value()) << protocol.error().message;
  return *protocol;
}

Protocol eight_directions() {
  Protocol p = protocol_of(scheduler::testing::small_protocol());
  p.perturbation.directions = 8;
  p.perturbation.repeats = 2;
  return p;
}

TEST(Draws, AreTheStandardsSequenceMappedToTheUnitInterval) {
  // Stream 0 of seed 0 is seeded with splitmix64's finaliser of 0, which is 0.
  std::mt19937_64 standard(0);
  Draws draws(0, 0);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(draws.uniform(0.0, 1.0), static_cast<double>(standard() >> 11) / 9007199254740992.0);
  }
}

TEST(Draws, BelowIsUniform) {
  Draws draws(3, 1);
  std::array<int, 6> counts{};
  for (int i = 0; i < 60000; ++i) ++counts[draws.below(6)];
  // Chi-square with 5 degrees of freedom: 20.5 is passed with probability 0.001 (table).
  double chi2 = 0.0;
  for (const int count : counts) chi2 += (count - 10000.0) * (count - 10000.0) / 10000.0;
  EXPECT_LT(chi2, 20.5);
}

TEST(Draws, StreamsDiffer) {
  EXPECT_NE(Draws(3, 1).uniform(0.0, 1.0), Draws(3, 2).uniform(0.0, 1.0));
  EXPECT_NE(Draws(3, 1).uniform(0.0, 1.0), Draws(4, 1).uniform(0.0, 1.0));
}

TEST(Plan, GivesEachDirectionAsOftenAsTheProtocolSays) {
  const Plan plan = build_plan(eight_directions(), 1);
  ASSERT_EQ(plan.trials.size(), 2u * 2u * 16u);
  std::map<std::tuple<std::uint32_t, int, double>, int> times;
  for (const auto& trial : plan.trials) {
    ++times[{trial.program.posture_index(), trial.program.set_number(), trial.program.direction_deg()}];
  }
  EXPECT_EQ(times.size(), 2u * 2u * 8u);
  for (const auto& [key, count] : times) {
    EXPECT_EQ(count, 2);
    EXPECT_EQ(std::fmod(std::get<2>(key), 45.0), 0.0);
  }
}

TEST(Plan, MovesEverySecondSetByTheSecondAmplitude) {
  Protocol protocol = eight_directions();
  protocol.perturbation.sets = 3;
  protocol.perturbation.second_amplitude = 0.008;
  for (const auto& trial : build_plan(protocol, 1).trials)
    EXPECT_EQ(trial.program.amplitude_m(), trial.program.set_number() == 2 ? 0.008 : 0.005);
}

TEST(Plan, DrawsWaitsAndHoldsOverTheirWholeRange) {
  double low = 10.0, high = 0.0, sum = 0.0;
  int n = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    for (const auto& trial : build_plan(eight_directions(), seed).trials) {
      const double wait = trial.program.wait_s();
      ASSERT_GE(wait, 3.0);
      ASSERT_LT(wait, 5.0);
      ASSERT_GE(trial.program.hold_s(), 1.5);
      ASSERT_LT(trial.program.hold_s(), 2.0);
      low = std::min(low, wait);
      high = std::max(high, wait);
      sum += wait;
      ++n;
    }
  }
  EXPECT_LT(low, 3.01);
  EXPECT_GT(high, 4.99);
  // Mean of a uniform: 4, with a standard error of (2 / sqrt 12) / sqrt n; five of them.
  EXPECT_NEAR(sum / n, 4.0, 5.0 * 2.0 / std::sqrt(12.0 * n));
}

TEST(Plan, IsTheSameForTheSameSeedAndAnotherForAnother) {
  const auto directions = [](std::uint64_t seed) {
    std::vector<double> all;
    for (const auto& trial : build_plan(eight_directions(), seed).trials) {
      all.push_back(trial.program.direction_deg());
      all.push_back(trial.program.wait_s());
    }
    return all;
  };
  EXPECT_EQ(directions(5), directions(5));
  EXPECT_NE(directions(5), directions(6));
}

TEST(Plan, OrdersSetsDifferently) {
  const Plan plan = build_plan(eight_directions(), 1);
  std::set<std::vector<double>> orders;
  for (const Block& block : plan.blocks) {
    std::vector<double> order;
    for (const auto index : block.order) order.push_back(plan.trials[index].program.direction_deg());
    orders.insert(order);
  }
  EXPECT_EQ(orders.size(), plan.blocks.size());
}

TEST(Plan, PutsTheHandlesHomeAtThePosture) {
  Protocol p = protocol_of(scheduler::testing::small_protocol("shoulder_angle_rad = 0.5\n"));
  Plan plan = build_plan(p, 1);
  bind_rig(plan, p, id_of("rig/test"), {0.30, 0.35});
  for (const auto& trial : plan.trials) {
    const auto& position = trial.program.posture_m();
    const auto& origin = trial.program.shoulder_origin_m();
    const double c = std::cos(0.5), s = std::sin(0.5);  // p_R = origin + Rot(angle) p_S, written out
    EXPECT_NEAR(origin[0] + c * position[0] - s * position[1], 0.30, 1e-12);
    EXPECT_NEAR(origin[1] + s * position[0] + c * position[1], 0.35, 1e-12);
    EXPECT_EQ(trial.program.rig_id(), id_of("rig/test"));
    EXPECT_EQ(trial.program.recording_index(), -1);
    EXPECT_EQ(trial.program.recording_event(), -1);
  }
}

TEST(Plan, DrawsOneBiasForASetAndItsRampForEachTrial) {
  Protocol p = protocol_of(scheduler::testing::small_loaded_protocol());
  p.perturbation.directions = 8;
  const Plan plan = build_plan(p, 2);
  ASSERT_EQ(plan.blocks.size(), 3u);
  EXPECT_EQ(plan.blocks[0].bias_force, 0.0);
  std::set<double> ramps;
  for (const std::size_t b : {1u, 2u}) {
    EXPECT_GE(plan.blocks[b].bias_force, 0.7);
    EXPECT_LT(plan.blocks[b].bias_force, 1.0);
    for (const auto index : plan.blocks[b].order) {
      const auto& program = plan.trials[index].program;
      EXPECT_GE(program.bias_ramp_s(), 2.0);
      EXPECT_LT(program.bias_ramp_s(), 3.0);
      EXPECT_EQ(program.bias_hold_s(), 1.0);
      EXPECT_EQ(program.bias_threshold_N(), 0.2);
      ramps.insert(program.bias_ramp_s());
    }
  }
  EXPECT_EQ(ramps.size(), 16u);
  EXPECT_NE(plan.blocks[1].bias_force, plan.blocks[2].bias_force);
  for (const auto index : plan.blocks[0].order) EXPECT_EQ(plan.trials[index].program.bias_ramp_s(), 0.0);
}

TEST(Plan, DrawsTheTimesOfARepeatAnew) {
  const Protocol p = protocol_of(scheduler::testing::small_protocol());
  const Plan plan = build_plan(p, 1);
  const auto first = commanded_program(p, plan, 3, id_of("s"), 4, 1, false, {});
  const auto repeat = commanded_program(p, plan, 3, id_of("s"), 9, 1, true, {});
  EXPECT_EQ(first.wait_s(), plan.trials[3].program.wait_s());
  EXPECT_NE(repeat.wait_s(), first.wait_s());
  EXPECT_GE(repeat.wait_s(), 3.0);
  EXPECT_LT(repeat.wait_s(), 5.0);
  EXPECT_EQ(repeat.direction_deg(), first.direction_deg());
  EXPECT_EQ(repeat.planned_index(), 3u);
  EXPECT_EQ(repeat.attempt(), 9u);
}

TEST(Plan, PutsRepeatsAtEveryPlaceEquallyOften) {
  std::array<int, 4> counts{};
  for (std::uint32_t attempt = 1; attempt <= 4000; ++attempt) ++counts[requeue_place(1, attempt, 3)];
  // Chi-square with 3 degrees of freedom: 16.3 is passed with probability 0.001 (table).
  double chi2 = 0.0;
  for (const int count : counts) chi2 += (count - 1000.0) * (count - 1000.0) / 1000.0;
  EXPECT_LT(chi2, 16.3);
}

TEST(Plan, PlaysRecordingsInOrder) {
  const Protocol p = protocol_of(
      "schema = 1\nkind = \"recording\"\nname = \"r\"\n[[recording]]\nname = \"a\"\nduration_s = 60.0\n"
      "[[recording]]\nname = \"b\"\nplay = \"events\"\nevents = 2\n[[recording.event]]\nset = 1\n"
      "[[recording.event]]\nset = 2\ndirection_deg = 45.0\n");
  const Plan plan = build_plan(p, 1);
  ASSERT_EQ(plan.trials.size(), 3u);
  EXPECT_EQ(plan.trials[0].program.kind(), v1::TRIAL_RECORDING);
  EXPECT_EQ(plan.trials[0].program.recording_index(), 0);
  EXPECT_EQ(plan.trials[0].program.recording_event(), -1);
  EXPECT_EQ(plan.trials[0].duration, 60.0);
  EXPECT_EQ(plan.trials[2].program.kind(), v1::TRIAL_PERTURBATION);
  EXPECT_EQ(plan.trials[2].program.recording_index(), 1);
  EXPECT_EQ(plan.trials[2].program.recording_event(), 1);
  EXPECT_EQ(plan.trials[2].program.direction_deg(), 45.0);
  EXPECT_EQ(plan.trials[2].program.set_number(), 2);
  ASSERT_EQ(plan.postures.size(), 2u);
  EXPECT_EQ(plan.postures[1].name(), "b");
  EXPECT_EQ(plan.postures[1].trials(), 2u);
}

TEST(Plan, BeginsWithTheReferenceContractionsAndLeavesTheOtherTrialsAsTheyAre) {
  const std::string text = scheduler::testing::small_protocol();
  const Plan without = build_plan(protocol_of(text), 5);
  const Plan with =
      build_plan(protocol_of(text + "\n[reference_contraction]\ntrials = 3\nduration_s = 2.5\n"), 5);
  ASSERT_EQ(with.trials.size(), without.trials.size() + 3);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(with.trials[i].program.kind(), v1::TRIAL_CONTRACTION);
    EXPECT_EQ(with.trials[i].program.hold_s(), 2.5);
    EXPECT_EQ(with.trials[i].program.amplitude_m(), 0.0);
    EXPECT_EQ(with.trials[i].program.planned_index(), i);
  }
  for (std::size_t i = 0; i < without.trials.size(); ++i) {
    v1::TrialProgram program = with.trials[i + 3].program;
    program.planned_index(static_cast<std::uint32_t>(i));
    EXPECT_EQ(program, without.trials[i].program) << i;
  }
}

TEST(Protocol, ALimitOfMuscleActivityNeedsAReferenceContraction) {
  const std::string text = scheduler::testing::small_protocol() + "\n[limits]\nmuscle_activity = 0.1\n";
  const auto refused = parse_protocol(text, "p.toml");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("[reference_contraction]"), std::string::npos)
      << refused.error().message;
  const auto taken = parse_protocol(text +
                                        "[reference_contraction]\n[[antagonists]]\nfirst = \"biceps\"\n"
                                        "second = \"triceps\"\n",
                                    "p.toml");
  ASSERT_TRUE(taken) << taken.error().message;
  EXPECT_EQ(taken->muscles.most_activity, 0.1);
  EXPECT_EQ(taken->muscles.reference.trials, 2);
  EXPECT_EQ(taken->muscles.antagonists.at(0).second, "triceps");
}

}  // namespace
}  // namespace tonus::protocol
