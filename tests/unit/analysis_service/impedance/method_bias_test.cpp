#include "analysis_service/impedance/method_bias.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/cross_check.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "analysis_service/impedance/refined_identification.hpp"
#include "analysis_service/statistics/distributions.hpp"
#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

Options by(Method method) {
  Options options;
  options.method = method;
  options.has_trace = false;
  return options;
}

/// Mean error of the mass of `method` and mean stated bias, over many conditions.
struct MassBias {
  Eigen::Matrix2d error = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d stated = Eigen::Matrix2d::Zero();
};

MassBias mass_bias_of(Method method, const SimulatedRig& rig) {
  const SimulatedArm arm = typical_subject();
  constexpr int kConditions = 40;
  MassBias mean;
  for (int seed = 1; seed <= kConditions; ++seed) {
    const auto trials = simulate(arm, rig, directions(), static_cast<std::uint64_t>(seed));
    const Estimate found = identify(trials, by(method)).value();
    EXPECT_EQ(found.uncertainty.M.known_bias.rows(), 2);
    if (found.uncertainty.M.known_bias.rows() != 2) break;
    mean.error += (Eigen::Matrix2d(found.value.M) - arm.impedance.M) / kConditions;
    mean.stated += Eigen::Matrix2d(found.uncertainty.M.known_bias) / kConditions;
  }
  return mean;
}

TEST(MethodBias, OfLowPassDifferencesIsStatedWithoutCommandsByTheMotionThatTrialsHaveInCommon) {
  for (const double rise : {0.02, 0.1}) {
    SimulatedRig rig = rig_with_command();
    rig.is_command_recorded = false;
    rig.rise = rise;
    const auto [error, stated] = mass_bias_of(Method::kLowpass, rig);
    EXPECT_GT(error.cwiseAbs().maxCoeff(), 0.03 * typical_subject().impedance.M.cwiseAbs().maxCoeff());
    EXPECT_LT((error - stated).cwiseAbs().maxCoeff(), 0.15 * error.cwiseAbs().maxCoeff()) << rise;
  }
}

TEST(MethodBias, OfTheFourierSeriesIsStatedAfterAFastRiseOfARigThatFollowsItsCommand) {
  SimulatedRig rig = rig_that_follows_its_command();
  rig.rise = 0.04;
  const auto [error, stated] = mass_bias_of(Method::kOptimal, rig);
  EXPECT_GT(error.cwiseAbs().maxCoeff(), 0.01 * typical_subject().impedance.M.cwiseAbs().maxCoeff());
  EXPECT_LT((error - stated).cwiseAbs().maxCoeff(), 0.15 * error.cwiseAbs().maxCoeff());
}

TEST(MethodBias, OfLowPassDifferencesIsWhatTheyErrOverManyConditions) {
  const auto [error, stated] = mass_bias_of(Method::kLowpass, rig_with_command());
  const double largest = typical_subject().impedance.M.cwiseAbs().maxCoeff();
  EXPECT_GT(error.cwiseAbs().maxCoeff(), 0.03 * largest);  // there is a bias to find
  EXPECT_LT((error - stated).cwiseAbs().maxCoeff(), 0.15 * error.cwiseAbs().maxCoeff());
}

TEST(MethodBias, WidensIntervalsAndLeavesTheValue) {
  auto trials = simulate(typical_subject(), rig_with_command(), directions(), 3);
  const Estimate with = identify(trials, by(Method::kLowpass)).value();
  for (Trial& trial : trials) trial.commanded.resize(0, 0);
  const Estimate without = identify(trials, by(Method::kLowpass)).value();
  EXPECT_EQ(flatten(with.value), flatten(without.value));
  const Eigen::VectorXd half = statistics::student_t_factor(0.95, 15.0) * flatten(with.std);
  for (const Estimate* found : {&with, &without}) {
    EXPECT_TRUE((flatten(found->low).array() <= (flatten(with.value) - half).array() + 1e-9).all());
    EXPECT_TRUE((flatten(found->high).array() >= (flatten(with.value) + half).array() - 1e-9).all());
    const AxisMatrix& bias = found->uncertainty.M.known_bias;
    ASSERT_EQ(bias.size(), 4);
    EXPECT_NEAR(found->high.M(0, 0) - found->value.M(0, 0) - half[0], std::max(0.0, -bias(0, 0)), 1e-12);
  }
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

/// Method refined's numbers of one condition, and the same as an estimate to be changed.
struct Compared {
  refined::Estimate refined;
  Estimate other;
};

Compared compared(const SimulatedRig& rig) {
  const auto trials = simulate(typical_subject(), rig, directions(), 3);
  std::vector<const Trial*> pointers;
  pointers.reserve(trials.size());
  for (const Trial& trial : trials) pointers.push_back(&trial);
  return {find_refined(pointers, by(Method::kRefined)), identify(trials, by(Method::kRefined)).value()};
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

TEST(CrossCheck, PassesOnARigThatFollowsItsCommandFast) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto trials = simulate(typical_subject(), rig_that_follows_its_command(), directions(), seed);
    const Estimate found = identify(trials, by(Method::kStateVariable)).value();
    const auto check = std::ranges::find(found.checks, FitTest::kCrossCheck, &FitCheck::test);
    ASSERT_NE(check, found.checks.end());
    EXPECT_TRUE(check->is_passed) << seed << ": " << check->value;
  }
}

TEST(CrossCheck, PassesMethodsThatAgreeToFourDigitsInDataWithoutNoise) {
  SimulatedRig rig = rig_with_command();
  rig.encoder_counts = rig.force_noise = rig.force_resolution = 0.0;
  auto [refined, other] = compared(rig);
  other.low = other.high = other.value;  // an interval without width
  other.value.K(0, 0) += 0.5 * kSameNumber * other.value.K.cwiseAbs().maxCoeff();
  EXPECT_TRUE(cross_check(refined, other)->is_passed());
}

TEST(CrossCheck, ComparesTheNearestOfWhatTheIntervalsHoldForAKnownBias) {
  auto [refined, other] = compared(rig_with_command());
  const double half = 0.5 * (other.high.K(1, 0) - other.low.K(1, 0));
  Parameters bias = other.value;
  for (AxisMatrix* matrix : {&bias.M, &bias.B, &bias.K}) matrix->setZero();
  other.value.K(1, 0) += 3.0 * half;
  const double without = cross_check(refined, other)->value;
  const auto with_bias = [&](double half_widths) {
    bias.K(1, 0) = half_widths * half;
    state_bias(bias, other);
    return cross_check(refined, other)->value;
  };
  EXPECT_NEAR(with_bias(1.0), without * 2.0 / 3.0, 1e-9);
  EXPECT_LT(with_bias(4.0), 1e-9);              // in between
  EXPECT_NEAR(with_bias(-1.0), without, 1e-9);  // farther
}

TEST(CrossCheck, SaysWhichElementDiffersAndByHowMuch) {
  auto [refined, other] = compared(rig_with_command());
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
