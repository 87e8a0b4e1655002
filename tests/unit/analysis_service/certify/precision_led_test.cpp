#include "analysis_service/certify/precision_led.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "analysis_service/impedance/refined_identification.hpp"
#include "services/core/parallel.hpp"

namespace tonus::certify {
namespace {

const Setting& living() {
  return *std::ranges::find_if(settings(), [](const Setting& setting) { return setting.name == "living"; });
}

Truth truth_of(std::size_t i) {
  std::mt19937_64 random(900 + i);
  return draw_truth(static_cast<int>(i % 5), random);
}

LedDesign led_by(double stiffness, int least, int most) {
  LedDesign led;
  led.setting = living();
  led.rule.stiffness = stiffness;
  led.rule.trials_least = least;
  led.rule.trials_most = most;
  led.rule.amplitude_most = led.design.amplitude;
  led.rule.rise_least = led.design.rise;
  return led;
}

/// A slice of `precision-campaign`: what it holds over many conditions stands in tests/RESULTS.md.
TEST(LedCondition, HoldsTheTrueStiffnessWhereItStops) {
  constexpr std::size_t kConditions = 40;
  const LedDesign led = led_by(0.066, 8, 32);
  std::vector<LedCondition> conditions(kConditions);
  for_each_in_parallel(kConditions,
                       [&](std::size_t i) { conditions[i] = simulate_led(truth_of(i), led, 4000 + i); });
  double inside = 0.0;
  std::vector<std::size_t> trials;
  for (std::size_t i = 0; i < kConditions; ++i) {
    const auto& estimate = conditions[i].estimate;
    const Eigen::Matrix2d K = truth_of(i).arm.K;
    inside +=
        (estimate.low.K.array() <= K.array() && K.array() <= estimate.high.K.array()).cast<double>().mean();
    trials.push_back(conditions[i].trials);
    if (conditions[i].end == protocol::LookEnd::kReached) {
      EXPECT_LE(conditions[i].look.stiffness, led.rule.stiffness);
      EXPECT_GT(conditions[i].trials, 8U);  // two looks
    }
  }
  EXPECT_GE(inside / kConditions, 0.93);
  std::ranges::sort(trials);
  EXPECT_LE(trials[kConditions / 2], 13U);
}

TEST(LedCondition, IsTheSameForTheSameSeed) {
  const LedDesign led = led_by(0.08, 6, 12);
  const LedCondition one = simulate_led(truth_of(1), led, 7);
  const LedCondition other = simulate_led(truth_of(1), led, 7);
  EXPECT_EQ(one.trials, other.trials);
  EXPECT_EQ(one.look.stiffness, other.look.stiffness);
  EXPECT_NE(one.look.stiffness, simulate_led(truth_of(1), led, 8).look.stiffness);
}

TEST(LedCondition, EndsWithTheMostTrialsWhereItsGoalIsOutOfReach) {
  const LedCondition condition = simulate_led(truth_of(2), led_by(0.001, 6, 9), 7);
  EXPECT_EQ(condition.end, protocol::LookEnd::kOutOfTrials);
  EXPECT_EQ(condition.trials, 9U);
}

TEST(WidenedIntervals, AreTheWiderOfTheTrialsScatterAndTheNoiseModel) {
  int widened = 0;
  int kept = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    std::mt19937_64 random(seed);
    Design design;
    design.trials = 8;
    const auto trials = simulate_condition(truth_of(seed), design, living(), random);
    impedance::Options options;
    options.method = impedance::Method::kRefined;
    const auto estimate = impedance::identify(trials, options);
    ASSERT_TRUE(estimate && estimate->status != impedance::Status::kUndetermined);
    auto wide = *estimate;
    impedance::widen_by_process(trials, options, wide);
    std::vector<const impedance::Trial*> pointers;
    for (const auto& trial : trials) pointers.push_back(&trial);
    const auto found = impedance::find_refined(pointers, options);
    const Eigen::MatrixXd& model = found.covariance->model_covariance();
    for (Eigen::Index i = 0; i < 2; ++i) {
      for (Eigen::Index j = 0; j < 2; ++j) {
        const Eigen::Index place = 7 * i + 4 + j;  // of K in vec(theta), whose rows are x" x' x 1
        const double by_model = 1.96 * std::sqrt(model(place, place));
        const double by_scatter = 0.5 * (estimate->high.K(i, j) - estimate->low.K(i, j));
        const double value = estimate->value.K(i, j);
        EXPECT_NEAR(wide.low.K(i, j), std::min(estimate->low.K(i, j), value - by_model), 1e-9 * by_scatter);
        EXPECT_NEAR(wide.high.K(i, j), std::max(estimate->high.K(i, j), value + by_model), 1e-9 * by_scatter);
        EXPECT_EQ(wide.value.K(i, j), estimate->value.K(i, j));
        ++(by_model > by_scatter ? widened : kept);
      }
    }
  }
  EXPECT_GT(widened, 0);
  EXPECT_GT(kept, 0);
}

TEST(WidenedIntervals, AreThoseOfMethodRefinedAlone) {
  std::mt19937_64 random(3);
  const auto trials = simulate_condition(truth_of(3), Design{}, living(), random);
  const impedance::Options options;  // state_variable
  const auto estimate = impedance::identify(trials, options);
  ASSERT_TRUE(estimate);
  auto wide = *estimate;
  impedance::widen_by_process(trials, options, wide);
  EXPECT_EQ(wide.low.K, estimate->low.K);
  EXPECT_EQ(wide.high.M, estimate->high.M);
}

}  // namespace
}  // namespace tonus::certify
