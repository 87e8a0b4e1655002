#include "analysis_service/spectral/identification.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "tests/campaigns/record_kinds.hpp"

namespace tonus::spectral {
namespace {

using campaigns::DrawnRecords;

DrawnRecords drawn(const std::string& kind, std::uint64_t seed = 1) {
  const auto& kinds = campaigns::record_kinds();
  return campaigns::draw(*std::ranges::find(kinds, kind, &campaigns::RecordKind::name), seed);
}

bool has_failed(const Estimate& estimate, Test test) {
  return std::ranges::any_of(estimate.checks,
                             [&](const Check& check) { return check.test == test && !check.is_passed; });
}

/// The worst error of an element over its 95 % half-width.
double error_in_half_widths(const Estimate& found, const DrawnRecords& truth) {
  double worst = 0.0;
  const auto compare = [&](const Eigen::MatrixXd& value, const Eigen::MatrixXd& error,
                           const Eigen::MatrixXd& true_value) {
    worst = std::max(worst, ((value - true_value).array().abs() / (found.t95 * error).array()).maxCoeff());
  };
  compare(found.M, found.M_error, truth.M);
  compare(found.B, found.B_error, truth.B);
  compare(found.K, found.K_error, truth.K);
  return worst;
}

// Closed form: a multisine whose force follows from Z(w) line by line. Resonance at 0.11 of the rate.
TEST(SpectralIdentification, BandLimitedMultisineAtATenthOfTheRateIsWithinTwoThousandths) {
  constexpr double kRate = 610.0;
  constexpr double kM = 0.02;
  const double natural = 2.0 * std::numbers::pi * 68.0;
  const double kK = kM * natural * natural;
  const double kB = 0.2 * kM * natural;
  constexpr Eigen::Index kRows = 610 * 30;
  Record record{1.0 / kRate, Eigen::MatrixXd::Zero(kRows, 1), Eigen::MatrixXd::Zero(kRows, 1), {}};
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
  for (double hz = 5.05; hz < 250.0; hz += 0.37) {
    const double w = 2.0 * std::numbers::pi * hz;
    const std::complex<double> Z(kK - w * w * kM, w * kB);
    const std::complex<double> x = std::polar(1e-3, phase(random));
    for (Eigen::Index i = 0; i < kRows; ++i) {
      const std::complex<double> e = std::polar(1.0, w * static_cast<double>(i) / kRate);
      record.displacement(i, 0) += (x * e).real();
      record.force(i, 0) += (Z * x * e).real();
    }
  }
  const Estimate found = identify({&record, 1});
  ASSERT_EQ(found.outcome, Outcome::kFound);
  EXPECT_NEAR(found.M(0, 0) / kM, 1.0, 2e-3);
  EXPECT_NEAR(found.B(0, 0) / kB, 1.0, 2e-3);
  EXPECT_NEAR(found.K(0, 0) / kK, 1.0, 2e-3);
  EXPECT_TRUE(found.is_ok());
}

TEST(SpectralIdentification, LagOfEachForceIsFoundWithItsSign) {
  for (const char* kind : {"skew", "two_axes_skew"}) {
    const DrawnRecords truth = drawn(kind);
    const Estimate found = identify(truth.records);
    ASSERT_EQ(found.outcome, Outcome::kFound) << kind;
    for (Eigen::Index axis = 0; axis < truth.lag.size(); ++axis)
      EXPECT_NEAR(found.lag[axis], truth.lag[axis], 2.0 * found.t95 * found.lag_error[axis] + 1e-5) << kind;
    EXPECT_TRUE(found.is_ok()) << kind;
  }
}

TEST(SpectralIdentification, RecordsThatTheModelDescribesAreRight) {
  for (const char* kind :
       {"resonance_0.002", "resonance_0.2", "noisy_motion", "drift", "gaps", "events", "short", "two_axes"}) {
    const DrawnRecords truth = drawn(kind);
    const Estimate found = identify(truth.records);
    EXPECT_TRUE(found.is_ok()) << kind;
    if (found.outcome == Outcome::kFound) {
      EXPECT_LT(error_in_half_widths(found, truth), 2.0) << kind;
    }
  }
}

struct Defect {
  const char* kind;
  Test test;
};
class WhatTheModelDoesNotHave : public testing::TestWithParam<Defect> {};
TEST_P(WhatTheModelDoesNotHave, IsNamedByItsOwnTest) {
  const Estimate found = identify(drawn(GetParam().kind).records);
  EXPECT_FALSE(found.is_ok());
  EXPECT_TRUE(has_failed(found, GetParam().test));
}
INSTANTIATE_TEST_SUITE_P(
    Records, WhatTheModelDoesNotHave,
    testing::Values(Defect{"friction", Test::kFriction}, Defect{"hardening", Test::kHardening},
                    Defect{"drag", Test::kFriction}, Defect{"position", Test::kPosition},
                    Defect{"wandering_stiffness", Test::kSteadiness}, Defect{"reflex", Test::kBands},
                    Defect{"second_mass", Test::kBands}, Defect{"clipped_force", Test::kClipping},
                    Defect{"held_force", Test::kHeldSamples}, Defect{"joined_force", Test::kHeldSamples},
                    Defect{"two_axes_friction", Test::kFriction},
                    Defect{"two_axes_crosstalk", Test::kSymmetry},
                    Defect{"two_axes_turned", Test::kSymmetry}),
    [](const auto& instance) { return std::string(instance.param.kind); });

TEST(SpectralIdentification, TwoSinesAreNotEnoughToTestTheModelByAndTwelveAre) {
  const Estimate two = identify(drawn("two_tones").records);
  EXPECT_EQ(two.outcome, Outcome::kNone);
  EXPECT_EQ(two.shortage, Shortage::kTooFewFrequencies);
  EXPECT_LT(two.frequencies, kFewestFrequencies);
  EXPECT_TRUE(identify(drawn("twelve_tones").records).is_ok());
}

TEST(SpectralIdentification, GapsCostTheSegmentsThatTheyLieInAndNoMore) {
  DrawnRecords truth = drawn("resonance_0.05");
  Record& record = truth.records[0];
  record.is_missing.assign(static_cast<std::size_t>(record.samples()), false);
  for (const Eigen::Index row : {record.samples() / 3, record.samples() / 2, record.samples() / 2 + 1}) {
    record.is_missing[static_cast<std::size_t>(row)] = true;
    record.displacement(row, 0) = record.force(row, 0) = std::nan("");
  }
  const Estimate found = identify(truth.records);
  EXPECT_TRUE(found.is_ok());
  EXPECT_LT(error_in_half_widths(found, truth), 2.0);
}

TEST(SpectralIdentification, RecordsWithoutNumbersSayWhatIsMissing) {
  DrawnRecords truth = drawn("resonance_0.05");
  Record few = truth.records[0];
  few.displacement.conservativeResize(150, 1);
  few.force.conservativeResize(150, 1);
  EXPECT_EQ(identify({&few, 1}).shortage, Shortage::kTooFewSamples);
  Record still = truth.records[0];
  still.force.setConstant(2.0);
  EXPECT_EQ(identify({&still, 1}).shortage, Shortage::kNoMotion);
  Record unrelated = truth.records[0];
  unrelated.force = drawn("resonance_0.05", 2).records[0].force;
  const Eigen::Index rows = std::min(unrelated.force.rows(), unrelated.displacement.rows());
  unrelated.force.conservativeResize(rows, 1);
  unrelated.displacement.conservativeResize(rows, 1);
  const Estimate found = identify({&unrelated, 1});
  EXPECT_FALSE(found.is_ok());
  EXPECT_NE(found.outcome, Outcome::kFound);
  EXPECT_EQ(identify({}).shortage, Shortage::kTooFewSamples);
}

TEST(SpectralIdentification, ForceOfTheArmThatIsFedBackWidensTheInterval) {
  const DrawnRecords truth = drawn("strong_disturbance");
  const Estimate found = identify(truth.records);
  EXPECT_GT(found.unaccounted, 0.05);
  EXPECT_TRUE(!found.is_ok() || error_in_half_widths(found, truth) < 2.0);
}

}  // namespace
}  // namespace tonus::spectral
