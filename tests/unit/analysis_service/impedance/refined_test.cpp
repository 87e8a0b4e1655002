#include <algorithm>
#include <gtest/gtest.h>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

Options refined() {
  Options options;
  options.method = Method::kRefined;
  return options;
}

TEST(RefinedMethod, IsOkOnASoundConditionAndHasAnIntervalForEveryElement) {
  const auto arm = typical_subject();
  const Estimate found = identify(simulate(arm, rig_with_command(), directions(), 3), refined()).value();
  EXPECT_EQ(found.status, Status::kOk);
  EXPECT_EQ(found.method, Method::kRefined);
  EXPECT_LT(relative_error(found.value.M, arm.impedance.M), 0.04);
  EXPECT_LT(relative_error(found.value.B, arm.impedance.B), 0.04);
  EXPECT_LT(relative_error(found.value.K, arm.impedance.K), 0.02);
  const Eigen::VectorXd value = flatten(found.value);
  EXPECT_TRUE((flatten(found.low).array() < value.array()).all());
  EXPECT_TRUE((flatten(found.high).array() > value.array()).all());
  EXPECT_GE(found.checks.size(), 6U);
}

TEST(RefinedMethod, DoesNotDependOnTheOrderOfTheTrials) {
  auto trials = simulate(typical_subject(), rig_with_command(), directions(1), 4);
  const Estimate once = identify(trials, refined()).value();
  std::ranges::reverse(trials);
  EXPECT_EQ(flatten(once.value), flatten(identify(trials, refined()).value().value));
}

TEST(RefinedMethod, SaysThatItNeedsTheCommand) {
  SimulatedRig rig = rig_with_command();
  rig.is_command_recorded = false;
  const Estimate found = identify(simulate(typical_subject(), rig, directions(1), 3), refined()).value();
  EXPECT_EQ(found.status, Status::kUndetermined);
  EXPECT_EQ(found.reasons, std::vector{Reason::kNoCommand});
}

TEST(RefinedMethod, RefusesModelsAndRecordsThatItDoesNotHave) {
  auto trials = simulate(typical_subject(), rig_with_command(), directions(1), 3);
  Options options = refined();
  options.model = Model::kCoriolis;
  EXPECT_EQ(identify(trials, options).error().message,
            "model: coriolis is not allowed for method refined; expected linear");
  for (Trial& trial : trials) trial.is_continuous = true;
  options = refined();
  options.record_method = Method::kRefined;
  EXPECT_EQ(
      identify(trials, options).error().message,
      "method: refined is not allowed for continuous records; expected lowpass, optimal, state_variable or "
      "spectral");
}

TEST(RefinedMethod, ServesOneAxis) {
  auto trials =
      simulate(typical_subject(), rig_with_command(), {0.0, 3.14159265, 0.0, 3.14159265, 0.0, 0.0}, 3);
  for (Trial& trial : trials) {
    // The handle is led along x: what the arm pulls along y is the rail's.
    trial.displacement = trial.displacement.leftCols(1).eval();
    trial.commanded = trial.commanded.leftCols(1).eval();
    trial.force = trial.force.leftCols(1).eval();
    trial.displacement_taken = trial.displacement_taken.head(1).eval();
    trial.force_taken = trial.force_taken.head(1).eval();
  }
  const Estimate found = identify(trials, refined()).value();
  ASSERT_NE(found.status, Status::kUndetermined);
  EXPECT_GT(found.value.K(0, 0), 0.0);
  EXPECT_EQ(found.value.M.size(), 1);
}

}  // namespace
}  // namespace tonus::impedance::test
