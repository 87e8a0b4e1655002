#include "analysis_service/impedance/method_bias.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/cross_check.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "analysis_service/impedance/refined_identification.hpp"
#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

Options by(Method method) {
  Options options;
  options.method = method;
  options.has_trace = false;
  return options;
}

TEST(MethodBias, OfLowPassDifferencesIsWhatTheyErrOverManyConditions) {
  const SimulatedArm arm = typical_subject();
  constexpr int kConditions = 40;
  Eigen::Matrix2d error = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d stated = error;
  for (int seed = 1; seed <= kConditions; ++seed) {
    const auto trials = simulate(arm, rig_with_command(), directions(), static_cast<std::uint64_t>(seed));
    const Estimate found = identify(trials, by(Method::kLowpass)).value();
    ASSERT_EQ(found.uncertainty.M.known_bias.rows(), 2);
    error += (Eigen::Matrix2d(found.value.M) - arm.impedance.M) / kConditions;
    stated += Eigen::Matrix2d(found.uncertainty.M.known_bias) / kConditions;
  }
  const double largest = arm.impedance.M.cwiseAbs().maxCoeff();
  EXPECT_GT(error.cwiseAbs().maxCoeff(), 0.03 * largest);  // there is a bias to find
  EXPECT_LT((error - stated).cwiseAbs().maxCoeff(), 0.15 * error.cwiseAbs().maxCoeff());
}

TEST(MethodBias, WidensIntervalsAndLeavesTheValue) {
  auto trials = simulate(typical_subject(), rig_with_command(), directions(), 3);
  const Estimate with = identify(trials, by(Method::kLowpass)).value();
  for (Trial& trial : trials) trial.commanded.resize(0, 0);
  const Estimate without = identify(trials, by(Method::kLowpass)).value();
  EXPECT_EQ(without.uncertainty.M.known_bias.size(), 0);
  EXPECT_EQ(flatten(with.value), flatten(without.value));
  EXPECT_TRUE((flatten(with.low).array() <= flatten(without.low).array()).all());
  EXPECT_TRUE((flatten(with.high).array() >= flatten(without.high).array()).all());
  const AxisMatrix& bias = with.uncertainty.M.known_bias;
  EXPECT_NEAR(with.high.M(0, 0) - without.high.M(0, 0), std::max(0.0, -bias(0, 0)), 1e-12);
}

TEST(MethodBias, DoesNotDependOnTheOrderOfTheTrials) {
  auto trials = simulate(typical_subject(), rig_with_command(), directions(), 4);
  const Estimate once = identify(trials, by(Method::kOptimal)).value();
  std::ranges::reverse(trials);
  EXPECT_EQ(once.uncertainty.B.known_bias,
            identify(trials, by(Method::kOptimal)).value().uncertainty.B.known_bias);
}

TEST(MethodBias, IsNotStatedForRefined) {
  const auto trials = simulate(typical_subject(), rig_with_command(), directions(), 3);
  EXPECT_EQ(identify(trials, by(Method::kRefined)).value().uncertainty.K.known_bias.size(), 0);
}

TEST(ResampledCondition, IsTheMeasuredConditionWhereEachTrialGetsItsOwnBack) {
  const auto trials = simulate(typical_subject(), rig_with_command(), directions(), 3);
  std::vector<const Trial*> pointers;
  for (const Trial& trial : trials) pointers.push_back(&trial);
  const ResampledCondition condition(pointers, find_refined(pointers, by(Method::kRefined)));
  ASSERT_EQ(condition.size(), trials.size());
  const Trial again = condition.trial(2, 2, 1.0, condition.impedance());
  EXPECT_EQ(again.onset, trials[2].onset);
  EXPECT_LT((again.displacement - trials[2].displacement).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((again.force - trials[2].force).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(CrossCheck, PassesOnSoundDataAndStandsWithBothMethods) {
  const auto trials = simulate(typical_subject(), rig_with_command(), directions(), 3);
  const auto value_of = [&](Method method) {
    const Estimate found = identify(trials, by(method)).value();
    const auto check = std::ranges::find(found.checks, FitTest::kCrossCheck, &FitCheck::test);
    EXPECT_NE(check, found.checks.end()) << name_of(method);
    EXPECT_TRUE(check->is_passed) << name_of(method) << check->value;
    return check->value;
  };
  EXPECT_EQ(value_of(Method::kRefined), value_of(Method::kStateVariable));
}

TEST(CrossCheck, PassesMethodsThatAgreeToFourDigitsInDataWithoutNoise) {
  SimulatedRig rig = rig_with_command();
  rig.encoder_counts = rig.force_noise = rig.force_resolution = 0.0;
  const auto trials = simulate(typical_subject(), rig, directions(), 3);
  std::vector<const Trial*> pointers;
  for (const Trial& trial : trials) pointers.push_back(&trial);
  const refined::Estimate refined = find_refined(pointers, by(Method::kRefined));
  Estimate other = identify(trials, by(Method::kRefined)).value();
  other.low = other.high = other.value;  // an interval without width
  other.value.K(0, 0) += 0.5 * kSameNumber * other.value.K.cwiseAbs().maxCoeff();
  EXPECT_TRUE(cross_check(refined, other)->is_passed());
}

TEST(CrossCheck, SaysWhichElementDiffersAndByHowMuch) {
  const auto trials = simulate(typical_subject(), rig_with_command(), directions(), 3);
  std::vector<const Trial*> pointers;
  for (const Trial& trial : trials) pointers.push_back(&trial);
  const refined::Estimate refined = find_refined(pointers, by(Method::kRefined));
  Estimate other = identify(trials, by(Method::kRefined)).value();
  const double half = 0.5 * (other.high.K(1, 0) - other.low.K(1, 0));
  const auto shifted_by = [&](double half_widths) {
    Estimate shifted = other;
    shifted.value.K(1, 0) += half_widths * half;
    return cross_check(refined, shifted).value();
  };
  // Equal half-widths, and what the methods' discretisations may differ by.
  const double same = kSameNumber * other.value.K.cwiseAbs().maxCoeff();
  EXPECT_NEAR(shifted_by(1.0).value, half / std::hypot(half, half, same), 2e-3);
  EXPECT_TRUE(shifted_by(1.0).is_passed());
  const CrossCheck found = shifted_by(3.0);
  EXPECT_FALSE(found.is_passed());
  EXPECT_NE(found.detail.find(fmt::format("differ by {:.2f} joint 95 % half-widths in K(2,1)", found.value)),
            std::string::npos)
      << found.detail;
}

}  // namespace
}  // namespace tonus::impedance::test
