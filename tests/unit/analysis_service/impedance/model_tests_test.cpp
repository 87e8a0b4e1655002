#include "analysis_service/impedance/model_tests.hpp"

#include <algorithm>
#include <gtest/gtest.h>

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

bool has(const Estimate& estimate, Reason reason) {
  return std::ranges::find(estimate.reasons, reason) != estimate.reasons.end();
}

std::vector<Trial> measured(bool is_command_recorded, std::uint64_t seed) {
  SimulatedRig rig;
  rig.rise = 0.1;
  rig.is_command_recorded = is_command_recorded;
  return simulate(typical_subject(), rig, directions(), seed);
}

/// Adds a spring that hardens by `share` of K to 5 mm: the force law holds, whatever moved the hand.
void harden(std::vector<Trial>& trials, double share) {
  const Eigen::Matrix2d K = typical_subject().impedance.K;
  for (Trial& trial : trials) {
    for (Eigen::Index k = 0; k < trial.samples(); ++k) {
      const Eigen::Vector2d x = trial.displacement.row(k).transpose();
      trial.force.row(k) += (share * x.squaredNorm() / 25e-6 * K * x).transpose();
    }
  }
}

TEST(ModelTests, EveryMethodNamesAHardeningSpringWithAndWithoutCommands) {
  for (const bool is_command_recorded : {true, false}) {
    auto trials = measured(is_command_recorded, 11);
    harden(trials, 0.3);
    for (const Method method : kMethods) {
      const Estimate found = identify(trials, by(method)).value();
      EXPECT_EQ(found.status, Status::kSuspect) << name_of(method);
      EXPECT_TRUE(has(found, Reason::kHardening)) << name_of(method) << " " << is_command_recorded;
      ASSERT_TRUE(found.details.contains(Reason::kHardening));
      EXPECT_NE(found.details.at(Reason::kHardening).find("cube of the displacement"), std::string::npos);
    }
  }
}

/// Five to seven trials of a quiet rig.
std::vector<Trial> few_trials(bool is_command_recorded, std::size_t count, std::uint64_t seed) {
  SimulatedRig rig = rig_that_follows_its_command();
  rig.is_command_recorded = is_command_recorded;
  auto trials = simulate(typical_subject(), rig, directions(), seed);
  trials.resize(count);
  return trials;
}

TEST(ModelTests, EveryMethodNamesAHardeningSpringFromFiveTrialsOn) {
  for (const bool is_command_recorded : {true, false}) {
    for (const std::size_t count : {5U, 6U, 7U}) {
      auto trials = few_trials(is_command_recorded, count, 11);
      harden(trials, 0.1);
      for (const Method method : kMethods) {
        EXPECT_TRUE(has(identify(trials, by(method)).value(), Reason::kHardening))
            << name_of(method) << " " << is_command_recorded << " " << count;
      }
    }
  }
}

TEST(ModelTests, EveryMethodNamesCoulombFrictionFromFiveTrialsOn) {
  for (const bool is_command_recorded : {true, false}) {
    auto trials = few_trials(is_command_recorded, 5, 12);
    for (Trial& trial : trials) {
      const Signals x = trial.displacement;
      for (Eigen::Index k = trial.onset; k + 1 < trial.samples(); ++k) {
        const Eigen::Vector2d v = (x.row(k + 1) - x.row(k - 1)).transpose() / (2.0 * trial.sample_period);
        trial.force.row(k) += (0.3 / (v.norm() + 2e-3) * v).transpose();
      }
    }
    for (const Method method : kMethods) {
      EXPECT_TRUE(has(identify(trials, by(method)).value(), Reason::kFriction))
          << name_of(method) << " " << is_command_recorded;
    }
  }
}

TEST(ModelTests, LeaveFiveTrialsOfALinearArmOkWithAndWithoutCommands) {
  int refused = 0;
  for (const bool is_command_recorded : {true, false}) {
    for (const std::uint64_t seed : {31U, 32U, 33U, 34U, 35U, 36U}) {
      auto trials = measured(is_command_recorded, seed);
      trials.resize(5);
      for (const auto& some : {trials, few_trials(is_command_recorded, 5, seed)})
        refused += identify(some, by(Method::kStateVariable)).value().status == Status::kOk ? 0 : 1;
    }
  }
  EXPECT_LE(refused, 1);
}

TEST(ModelTests, LeaveALinearArmOkByEveryMethodWithAndWithoutCommands) {
  int refused = 0;
  for (const bool is_command_recorded : {true, false}) {
    for (const std::uint64_t seed : {21U, 22U, 23U, 24U}) {
      const auto trials = measured(is_command_recorded, seed);
      for (const Method method : kMethods)
        refused += identify(trials, by(method)).value().status == Status::kOk ? 0 : 1;
    }
  }
  EXPECT_LE(refused, 1);
}

TEST(ModelTests, ATermInDoubtIsInTheIntervals) {
  refined::Estimate found;
  found.theta = Eigen::MatrixXd::Ones(4, 1);
  Estimate estimate;
  estimate.axes = 1;
  for (Parameters* numbers : {&estimate.value, &estimate.low, &estimate.high})
    *numbers = parameters_from(Eigen::MatrixXd(found.theta), 1);
  Eigen::MatrixXd change(4, 1);
  change << 0.1, -0.2, 3.0, 0.5;
  refined::AlternativeTest test;
  test.change = change;
  test.p = 2.0 * kDoubtfulBelow;
  found.alternatives = {test};
  carry_doubts(found, estimate);
  EXPECT_EQ(estimate.high.K(0, 0), 1.0);  // ruled out
  found.alternatives.front().p = 0.5 * kDoubtfulBelow;
  carry_doubts(found, estimate);
  EXPECT_DOUBLE_EQ(estimate.high.M(0, 0), 1.1);
  EXPECT_DOUBLE_EQ(estimate.low.M(0, 0), 1.0);
  EXPECT_DOUBLE_EQ(estimate.low.B(0, 0), 0.8);
  EXPECT_DOUBLE_EQ(estimate.high.K(0, 0), 4.0);
  EXPECT_EQ(estimate.value.K(0, 0), 1.0);
}

}  // namespace
}  // namespace tonus::impedance::test
