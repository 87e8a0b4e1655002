#include "analysis_service/certify/certification.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace tonus::certify {
namespace {

/// A slice of the campaign (tests/RESULTS.md): its limits are the long form's with room for so few
/// conditions.
std::vector<MethodWorth> slice(std::size_t setting, std::size_t conditions = 40) {
  Cell cell;
  cell.setting = settings()[setting];
  cell.conditions = conditions;
  cell.seed = 7;
  return certify(cell);
}

const MethodWorth& of(const std::vector<MethodWorth>& all, impedance::Method method) {
  return *std::ranges::find(all, method, &MethodWorth::method);
}

TEST(Certify, RefinedIsCloseToTheBoundAndItsIntervalsHoldTheTruth) {
  for (const std::size_t setting : {0U, 2U}) {
    const auto all = slice(setting);
    const MethodWorth& refined = of(all, impedance::Method::kRefined);
    EXPECT_EQ(refined.undetermined, 0U);
    for (std::size_t matrix = 0; matrix < 4; ++matrix)
      EXPECT_GT(refined.matrices[matrix].coverage, 0.88) << setting << " " << matrix;
    for (std::size_t matrix = 0; matrix < 3; ++matrix)
      EXPECT_LT(refined.matrices[matrix].over_bound, 1.4) << setting << " " << matrix;
  }
}

TEST(Certify, RefinedErrsLessThanEveryPublishedMethodUnderALivingArm) {
  const auto all = slice(2);
  const MethodWorth& refined = of(all, impedance::Method::kRefined);
  for (const auto method : impedance::kMethods) {
    for (std::size_t matrix = 0; matrix < 3; ++matrix)
      EXPECT_LT(refined.matrices[matrix].rmse, of(all, method).matrices[matrix].rmse);
  }
}

TEST(Certify, RefinedFlagsHardlyAnySoundConditionAlsoWithEncoderStepsAndALivingArm) {
  for (const std::size_t setting : {0U, 1U, 2U})
    EXPECT_LE(of(slice(setting, 20), impedance::Method::kRefined).suspect, 1U) << setting;
}

TEST(Certify, RefinedFlagsSlackOfOneMillimetreAndHardeningOfAThird) {
  for (const NamedError& one : model_errors()) {
    if (one.error.slack < 9e-4 && one.error.hardening < 0.29) continue;
    Cell cell;
    cell.setting = settings()[2];
    cell.setting.error = one.error;
    cell.conditions = 10;
    cell.seed = 11;
    EXPECT_EQ(of(certify(cell), impedance::Method::kRefined).suspect, 10U) << one.name;
  }
}

/// Conditions by every method, of each arm in a setting.
std::size_t wrong_and_ok(std::size_t setting, const NamedError& arm, std::size_t conditions) {
  Cell cell;
  cell.setting = settings()[setting];
  cell.setting.error = arm.error;
  cell.conditions = conditions;
  cell.seed = 31;
  std::size_t wrong = 0;
  for (const MethodWorth& worth : certify(cell)) {
    EXPECT_EQ(worth.right + worth.refused + worth.wrong, conditions);
    wrong += worth.wrong;
  }
  return wrong;
}

TEST(Certify, NoMethodIsWrongAndOkOnAnArmThatIsNotLinear) {
  constexpr std::size_t kConditions = 5;
  for (const std::size_t setting : {0U, 2U}) {
    std::size_t wrong = 0;
    for (const NamedError& arm : model_errors()) wrong += wrong_and_ok(setting, arm, kConditions);
    EXPECT_LE(wrong, model_errors().size() * kConditions * 4 / 50) << settings()[setting].name;
  }
}

TEST(Certify, NoMethodRefusesManyLinearArms) {
  for (std::size_t setting = 0; setting < settings().size(); ++setting) {
    for (const MethodWorth& worth : slice(setting, 20))
      EXPECT_LE(worth.refused, 2U) << settings()[setting].name << impedance::name_of(worth.method);
  }
}

TEST(Certify, SameSeedGivesTheSameNumbers) {
  Cell cell;
  cell.setting = settings()[0];
  cell.conditions = 4;
  EXPECT_EQ(certify(cell)[3].matrices[0].rmse, certify(cell)[3].matrices[0].rmse);
}

}  // namespace
}  // namespace tonus::certify
