#include "analysis_service/identification/trial_judge.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>

#include "tests/support/made_up_trial/made_up_trial.hpp"

namespace tonus::identification {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::made_up_trial;
using testing::Recipe;
using testing::TrueArm;

Verdict judge(const MeasuredTrial& trial, const RigGeometry& rig = testing::made_up_rig()) {
  return TrialJudge().judge(trial, &rig);
}

Recipe loaded() {
  Recipe recipe;
  recipe.bias = {0.6, -0.5};
  return recipe;
}

TEST(TrialJudge, AcceptsACleanTrialAndStatesWhatItMeasured) {
  const auto verdict = judge(made_up_trial({}));
  EXPECT_TRUE(verdict.is_valid) << verdict.detail;
  EXPECT_THAT(verdict.defects, IsEmpty());
  EXPECT_NEAR(verdict.measured.start_offset, 0.0, 1e-12);
  EXPECT_NEAR(verdict.measured.rest_speed, 0.0, 1e-9);
  EXPECT_NEAR(verdict.measured.rest_force, 0.0, 1e-9);
  EXPECT_NEAR(verdict.measured.excursion, 0.005, 1e-9);  // the recipe's amplitude
  EXPECT_NEAR(verdict.measured.end_speed, 0.0, 1e-9);
  EXPECT_THAT(verdict.detail, HasSubstr("moved 5.0 mm (15.0)"));
}

TEST(TrialJudge, AcceptsACleanLoadedTrial) {
  const auto verdict = judge(made_up_trial(loaded()));
  EXPECT_TRUE(verdict.is_valid) << verdict.detail;
  EXPECT_NEAR(verdict.measured.bias_error, 0.0, 1e-9);
  EXPECT_NEAR(verdict.measured.bias_held, 1.0, 1e-9);
}

TEST(TrialJudge, AcceptsEncodersStepsAndSensorNoise) {
  Recipe recipe;
  int row = 0;
  recipe.added_force = [&row](double, Phase) {  // 0.05 N, the published noise, as an alternating sequence
    const double sign = (row++ % 2 == 0) ? 0.05 : -0.05;
    return Eigen::Vector2d(sign, -sign);
  };
  auto trial = made_up_trial(recipe);
  for (auto& sample : trial.rows) {
    for (double& count : sample.raw.encoder_count) count = std::round(count);
  }
  const auto verdict = judge(trial);
  EXPECT_TRUE(verdict.is_valid) << verdict.detail;
}

TEST(TrialJudge, RefusesAStartOutsideTheTargetCircle) {
  Recipe recipe;
  recipe.added_way = [](double, Phase) { return Eigen::Vector2d(0.0, 0.0061); };
  const auto verdict = judge(made_up_trial(recipe));
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kOffTarget));
  EXPECT_NEAR(verdict.measured.start_offset, 0.0061, 1e-9);
  EXPECT_THAT(verdict.detail, HasSubstr("6.1 mm from its place, allowed 5.0 mm"));
  recipe.added_way = [](double, Phase) { return Eigen::Vector2d(0.0, 0.0049); };
  EXPECT_TRUE(judge(made_up_trial(recipe)).is_valid);
}

TEST(TrialJudge, RefusesABiasThatIsNeverReached) {
  Recipe recipe = loaded();
  recipe.added_force = [&](double, Phase phase) {  // a motor that gives 70 % of what it is told
    return phase == Phase::kBiasHold || phase == Phase::kPerturbing
               ? Eigen::Vector2d(-0.3 * Eigen::Vector2d(0.6, -0.5))
               : Eigen::Vector2d(0.0, 0.0);
  };
  const auto verdict = judge(made_up_trial(recipe));
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kBiasNotReached));
  EXPECT_NEAR(verdict.measured.bias_nearest, 0.3 * std::hypot(0.6, 0.5), 1e-9);
}

TEST(TrialJudge, RefusesABiasThatIsLeftBeforeTheOnset) {
  Recipe recipe = loaded();
  recipe.added_force = [](double t, Phase phase) {
    return phase == Phase::kBiasHold && t > -0.4 && t < -0.2 ? Eigen::Vector2d(0.0, 0.3)
                                                             : Eigen::Vector2d(0.0, 0.0);
  };
  const auto verdict = judge(made_up_trial(recipe));
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kBiasNotHeld));
  EXPECT_NEAR(verdict.measured.bias_error, 0.3, 1e-9);
}

TEST(TrialJudge, RefusesABiasThatIsHeldTooShortly) {
  auto trial = made_up_trial(loaded());
  trial.report.plan.bias_hold = 1.2;
  const auto verdict = judge(trial);
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kBiasNotHeld));
  EXPECT_THAT(verdict.detail, HasSubstr("held for 1.00 s, needed 1.20 s"));
}

TEST(TrialJudge, RefusesAHandThatMovesBeforeTheOnset) {
  Recipe recipe;
  recipe.added_way = [](double t, Phase) {  // 30 mm/s for the last 0.1 s, then still
    const double moved = 0.030 * std::clamp(t + 0.1, 0.0, 0.1);
    return Eigen::Vector2d(moved, 0.0);
  };
  const auto verdict = judge(made_up_trial(recipe));
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kEarlyReaction));
  EXPECT_GT(verdict.measured.rest_speed, 0.025);
  EXPECT_LE(verdict.measured.rest_speed, 0.030 + 1e-9);
}

TEST(TrialJudge, RefusesAHandThatPushesBeforeTheOnset) {
  Recipe recipe;
  recipe.added_force = [](double, Phase phase) {
    return phase == Phase::kWaiting ? Eigen::Vector2d(0.0, 1.2) : Eigen::Vector2d(0.0, 0.0);
  };
  auto verdict = judge(made_up_trial(recipe));
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kEarlyReaction));
  EXPECT_NEAR(verdict.measured.rest_force, 1.2, 1e-9);

  recipe.added_force = [](double t,
                          Phase phase) {  // 0.8 N in the last 0.1 s: its mean over the rest is small
    return phase == Phase::kWaiting && t > -0.1025 ? Eigen::Vector2d(0.8, 0.0) : Eigen::Vector2d(0.0, 0.0);
  };
  verdict = judge(made_up_trial(recipe));
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kEarlyReaction));
  EXPECT_NEAR(verdict.measured.rest_force, 0.8 * 0.1 / 0.5, 1e-9);
  EXPECT_NEAR(verdict.measured.rest_force_change, 0.8 * (1.0 - 0.1 / 0.5), 1e-9);
}

TEST(TrialJudge, RefusesASaturatedSensorByTheRigsFlagOrTheVolts) {
  auto flagged = made_up_trial({});
  flagged.rows[300].is_saturated = true;
  auto verdict = judge(flagged);
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kSaturated));
  EXPECT_EQ(verdict.measured.saturated_rows, 1U);

  RigGeometry rig = testing::made_up_rig();
  rig.force_saturation_V = 0.3;  // the perturbation's force passes 0.3 V
  verdict = judge(made_up_trial({}), rig);
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kSaturated));
}

TEST(TrialJudge, LetsSaturationPassOutsideRestAndPerturbation) {
  auto trial = made_up_trial({});
  trial.rows.front().is_saturated = true;  // centring
  trial.rows.back().is_saturated = true;   // way back
  EXPECT_TRUE(judge(trial).is_valid);
}

TEST(TrialJudge, RefusesAGap) {
  auto trial = made_up_trial({});
  for (std::size_t i = 300; i < 305; ++i) trial.rows[i].is_missing = true;
  trial.missing_rows = 5;
  const auto verdict = judge(trial);
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kGap));
  EXPECT_EQ(verdict.measured.missing_rows, 5U);
}

TEST(TrialJudge, LetsGapsOfARecordingPassUpToHalfOfItsRows) {
  auto trial = made_up_trial({});
  trial.report.plan.kind = TrialKind::kRecording;
  const std::size_t half = trial.rows.size() / 2;
  for (std::size_t i = 0; i < half; ++i) trial.rows[i].is_missing = true;
  EXPECT_TRUE(judge(trial).is_valid);
  trial.rows[half].is_missing = trial.rows[half + 1].is_missing = true;
  EXPECT_THAT(judge(trial).defects, ElementsAre(Defect::kGap));
}

TEST(TrialJudge, SeesAGapInTheAcquisitionStampsOfCompleteNumbers) {
  auto trial = made_up_trial({});
  for (std::size_t i = 300; i < trial.rows.size(); ++i) trial.rows[i].raw.acquisition_ns += 3 * 5'000'000LL;
  const auto verdict = judge(trial);
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kGap));
  EXPECT_EQ(verdict.measured.missing_rows, 3U);
}

TEST(TrialJudge, RefusesAnExcursionBeyondTheLimit) {
  Recipe recipe;
  recipe.amplitude = 0.0155;
  const auto verdict = judge(made_up_trial(recipe));
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kExcursion));
  EXPECT_NEAR(verdict.measured.excursion, 0.0155, 1e-9);
  recipe.amplitude = 0.0145;
  EXPECT_TRUE(judge(made_up_trial(recipe)).is_valid);
}

TEST(TrialJudge, RefusesAHandThatStillMovesAtTheEnd) {
  Recipe recipe;
  recipe.added_way = [](double t, Phase phase) {
    const double moved = phase == Phase::kPerturbing ? 0.030 * std::max(0.0, t - 1.5) : 0.0;
    return Eigen::Vector2d(0.0, moved);
  };
  const auto verdict = judge(made_up_trial(recipe));
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kNotAtRest));
  EXPECT_NEAR(verdict.measured.end_speed, 0.030, 1e-9);
}

TEST(TrialJudge, DoesNotTakeTheWayBackForUnrest) {
  Recipe recipe;
  recipe.added_way = [](double t, Phase phase) {
    return phase == Phase::kReturning ? Eigen::Vector2d(0.1 * (t - 1.75), 0.0) : Eigen::Vector2d(0.0, 0.0);
  };
  EXPECT_TRUE(judge(made_up_trial(recipe)).is_valid);
}

TEST(TrialJudge, RefusesAHandThatLetGoDuringThePerturbation) {
  const TrueArm arm;
  Recipe recipe;
  recipe.added_force = [&](double t, Phase phase) {
    return phase == Phase::kPerturbing && t > 0.5 ? Eigen::Vector2d(-arm.K * Eigen::Vector2d(0.005, 0.0))
                                                  : Eigen::Vector2d(0.0, 0.0);
  };
  const auto verdict = judge(made_up_trial(recipe));
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kLetGo));
  EXPECT_NEAR(verdict.measured.resistance, 0.0, 1e-9);
}

TEST(TrialJudge, RefusesAHandThatLetGoUnderABias) {
  Recipe recipe = loaded();
  recipe.added_force = [&](double, Phase phase) {
    return phase == Phase::kReturning ? Eigen::Vector2d(-recipe.bias) : Eigen::Vector2d(0.0, 0.0);
  };
  EXPECT_THAT(judge(made_up_trial(recipe)).defects, ElementsAre(Defect::kLetGo));
}

TEST(TrialJudge, LetsAPerturbationIntoTheSpringCentrePassThatLeavesNoForce) {
  const TrueArm arm;
  Recipe recipe = loaded();
  recipe.bias = -arm.K * Eigen::Vector2d(0.005, 0.0);  // N, all of it relieved by the displacement
  const auto verdict = judge(made_up_trial(recipe));
  EXPECT_TRUE(verdict.is_valid) << verdict.detail;
}

TEST(TrialJudge, NamesATrialThatTheRigDidNotComplete) {
  auto trial = made_up_trial({});
  trial.report.detail = "fault: speed";
  for (const auto end : {TrialEnd::kAborted, TrialEnd::kFaulted, TrialEnd::kNotCentred, TrialEnd::kRefused,
                         TrialEnd::kBrokenOff}) {
    trial.report.end = end;
    const auto verdict = judge(trial);
    EXPECT_THAT(verdict.defects, ElementsAre(Defect::kNotCompleted));
    EXPECT_THAT(verdict.detail, HasSubstr("fault: speed"));
  }
  trial.report.end = TrialEnd::kBiasNotReached;
  EXPECT_THAT(judge(trial).defects, ElementsAre(Defect::kBiasNotReached));
}

TEST(TrialJudge, RefusesATrialOfAnUnknownRig) {
  EXPECT_THAT(TrialJudge().judge(made_up_trial({}), nullptr).defects, ElementsAre(Defect::kUnknownRig));
}

TEST(TrialJudge, RefusesAPerturbationWithoutRest) {
  auto trial = made_up_trial({});
  const auto onset = trial.report.onset - trial.report.range.first;
  trial.rows.erase(trial.rows.begin(), trial.rows.begin() + static_cast<std::ptrdiff_t>(onset) - 5);
  trial.report.range.first = trial.report.onset - 5;
  EXPECT_THAT(judge(trial).defects, ElementsAre(Defect::kNotCompleted));
}

TEST(TrialJudge, RefusesAReportThatContradictsItself) {
  auto trial = made_up_trial({});
  trial.report.onset = trial.report.range.end;
  EXPECT_THAT(judge(trial).defects, ElementsAre(Defect::kGap));
  trial.report.sample_rate = 0.0;
  EXPECT_THAT(judge(trial).defects, ElementsAre(Defect::kGap));
}

TEST(TrialJudge, JudgesARecordingByCompletenessAndSaturationAlone) {
  Recipe recipe;
  recipe.amplitude = 0.05;                                                      // would be an excursion
  recipe.added_way = [](double, Phase) { return Eigen::Vector2d(0.02, 0.0); };  // would be off target
  auto trial = made_up_trial(recipe);
  trial.report.plan.kind = TrialKind::kRecording;
  EXPECT_TRUE(judge(trial).is_valid);
  trial.rows[10].is_missing = true;
  EXPECT_TRUE(judge(trial).is_valid) << "the segments beside a gap are used";
  for (std::size_t i = 20; i < trial.rows.size(); ++i) trial.rows[i].is_missing = true;
  EXPECT_THAT(judge(trial).defects, ElementsAre(Defect::kGap));
  trial.rows[11].is_saturated = true;
  EXPECT_THAT(judge(trial).defects, ElementsAre(Defect::kSaturated, Defect::kGap));
}

TEST(TrialJudge, NamesSeveralDefectsInOneLine) {
  Recipe recipe;
  recipe.amplitude = 0.016;
  recipe.added_way = [](double, Phase) { return Eigen::Vector2d(0.006, 0.0); };
  const auto verdict = judge(made_up_trial(recipe));
  EXPECT_THAT(verdict.defects, ElementsAre(Defect::kOffTarget, Defect::kExcursion));
  EXPECT_EQ(verdict.detail.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace tonus::identification
