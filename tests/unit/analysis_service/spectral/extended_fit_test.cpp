// Models beyond M, B, K on records of known truth (tests/campaigns), which the linear model refuses.
#include "analysis_service/spectral/extended_fit.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "analysis_service/spectral/identification.hpp"
#include "tests/campaigns/record_kinds.hpp"

namespace tonus::spectral {
namespace {

using campaigns::DrawnRecords;

DrawnRecords drawn(const std::string& kind, std::uint64_t seed) {
  const auto& kinds = campaigns::record_kinds();
  return campaigns::draw(*std::ranges::find(kinds, kind, &campaigns::RecordKind::name), seed);
}

Estimate identified(const DrawnRecords& truth, Addition addition) {
  Settings settings;
  settings.addition = addition;
  return identify(truth.records, settings);
}

void expect_within_intervals(const Estimate& found, const DrawnRecords& truth) {
  const auto compare = [&](const Eigen::MatrixXd& value, const Eigen::MatrixXd& error,
                           const Eigen::MatrixXd& true_value) {
    EXPECT_LT(((value - true_value).array().abs() / (found.t95 * error).array()).maxCoeff(), 1.6);
  };
  compare(found.M, found.M_error, truth.M);
  compare(found.B, found.B_error, truth.B);
  compare(found.K, found.K_error, truth.K);
}

TEST(ExtendedFit, FrictionIsFoundBesideTheImpedanceThatItHides) {
  for (const std::uint64_t seed : {1, 2}) {
    const DrawnRecords truth = drawn("friction", seed);
    ASSERT_FALSE(identified(truth, Addition::kNone).is_ok());
    const Estimate found = identified(truth, Addition::kFriction);
    EXPECT_TRUE(found.is_ok());
    expect_within_intervals(found, truth);
    ASSERT_EQ(found.parameters.size(), 1U);
    EXPECT_EQ(found.parameters[0].kind, Parameter::Kind::kFriction);
    EXPECT_GT(found.parameters[0].value, 20.0 * found.parameters[0].error);
  }
}

TEST(ExtendedFit, HardeningSpringHasItsStiffnessAtTheMeanPosition) {
  const DrawnRecords truth = drawn("hardening", 4);
  ASSERT_FALSE(identified(truth, Addition::kNone).is_ok());
  const Estimate found = identified(truth, Addition::kCubic);
  EXPECT_TRUE(found.is_ok());
  expect_within_intervals(found, truth);
  ASSERT_EQ(found.parameters.size(), 2U);
  EXPECT_EQ(found.parameters[1].kind, Parameter::Kind::kCubic);
  EXPECT_GT(found.parameters[1].value, 0.0);
}

TEST(ExtendedFit, ReflexIsFoundWithItsDelayAndLeavesTheIntrinsicStiffness) {
  const DrawnRecords truth = drawn("reflex", 1);  // a fifth of K with a delay of 30 to 60 ms
  ASSERT_FALSE(identified(truth, Addition::kNone).is_ok());
  const Estimate found = identified(truth, Addition::kReflex);
  EXPECT_TRUE(found.is_ok());
  expect_within_intervals(found, truth);
  ASSERT_EQ(found.parameters.size(), 3U);
  EXPECT_EQ(found.parameters[0].kind, Parameter::Kind::kReflexStiffness);
  EXPECT_NEAR(found.parameters[0].value, 0.2 * truth.K(0, 0), 0.01 * truth.K(0, 0));
  EXPECT_EQ(found.parameters[2].kind, Parameter::Kind::kReflexDelay);
  EXPECT_GT(found.parameters[2].value, 0.030);
  EXPECT_LT(found.parameters[2].value, 0.060);
}

TEST(ExtendedFit, ModelThatLacksWhatTheRecordHasIsRefusedAlike) {
  EXPECT_FALSE(identified(drawn("hardening", 1), Addition::kFriction).is_ok());
  EXPECT_FALSE(identified(drawn("friction", 1), Addition::kCubic).is_ok());
  EXPECT_FALSE(identified(drawn("clipped_force", 1), Addition::kCubic).is_ok());
}

TEST(AutomaticModel, IsTheSimplestThatPassesAndSaysWhatWasCompared) {
  Settings settings;
  settings.is_automatic = true;
  const Estimate plain = identify(drawn("resonance_0.01", 1).records, settings);
  EXPECT_TRUE(plain.is_ok());
  EXPECT_EQ(plain.addition, Addition::kNone);
  ASSERT_EQ(plain.compared.size(), 1U);
  EXPECT_TRUE(plain.compared[0].is_accepted);

  const DrawnRecords truth = drawn("friction", 1);
  const Estimate found = identify(truth.records, settings);
  EXPECT_TRUE(found.is_ok());
  EXPECT_EQ(found.addition, Addition::kFriction);
  expect_within_intervals(found, truth);
  ASSERT_EQ(found.compared.size(), 4U);
  EXPECT_FALSE(found.compared[0].is_accepted);
  EXPECT_TRUE(found.compared[1].is_accepted);
  EXPECT_LT(found.compared[1].bic, 0.0);
}

TEST(AutomaticModel, IsTheLinearOneWithItsReasonWhereNonePasses) {
  Settings settings;
  settings.is_automatic = true;
  const Estimate found = identify(drawn("clipped_force", 1).records, settings);
  EXPECT_FALSE(found.is_ok());
  EXPECT_EQ(found.addition, Addition::kNone);
  EXPECT_EQ(found.compared.size(), 4U);
}

}  // namespace
}  // namespace tonus::spectral
