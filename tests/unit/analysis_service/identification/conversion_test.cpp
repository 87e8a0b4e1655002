#include "analysis_service/identification/conversion.hpp"

#include <cmath>
#include <gmock/gmock.h>

#include "tests/support/made_up_trial/made_up_trial.hpp"

namespace tonus::identification {
namespace {

using ::testing::HasSubstr;
using testing::made_up_trial;
using testing::Recipe;

Result<impedance::Trial> convert_all(const MeasuredTrial& trial,
                                     const RigGeometry& rig = testing::made_up_rig()) {
  return trial_from_rows(frame_of(trial.report), rig, trial.rows,
                         trial.report.onset - trial.report.range.first);
}

TEST(TrialFromRows, KeepsHalfASecondOfRestAndLeavesTheWayBackOut) {
  const auto trial = convert_all(made_up_trial({}));
  ASSERT_TRUE(trial);
  EXPECT_EQ(trial->onset, 100);            // 0.5 s at 200 Hz
  EXPECT_EQ(trial->samples(), 100 + 350);  // and the perturbation's 1.75 s
  EXPECT_EQ(trial->number, 1U);
  EXPECT_DOUBLE_EQ(trial->sample_period, 0.005);
  EXPECT_EQ(trial->commanded.rows(), trial->samples());
}

TEST(TrialFromRows, UndoesTheRawConversion) {
  Recipe recipe;
  recipe.direction_deg = 90.0;
  const auto trial = convert_all(made_up_trial(recipe));
  ASSERT_TRUE(trial);
  // 1.75 s after the onset everything stands: X = (0, 5 mm), F = K X.
  const Eigen::Vector2d x = trial->displacement.row(trial->samples() - 1).transpose();
  const Eigen::Vector2d f = trial->force.row(trial->samples() - 1).transpose();
  EXPECT_NEAR((x - Eigen::Vector2d(0.0, 0.005)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((f - testing::TrueArm().K * Eigen::Vector2d(0.0, 0.005)).norm(), 0.0, 1e-9);
}

TEST(TrialFromRows, TaresAnUnloadedTrialByItsRestAndALoadedOneNot) {
  Recipe recipe;
  recipe.added_force = [](double, Phase) { return Eigen::Vector2d(0.4, -0.2); };  // an offset of the sensor
  auto trial = convert_all(made_up_trial(recipe));
  ASSERT_TRUE(trial);
  EXPECT_NEAR(trial->force.row(0).norm(), 0.0, 1e-9);

  recipe.added_force = nullptr;
  recipe.bias = {0.6, -0.5};
  trial = convert_all(made_up_trial(recipe));
  ASSERT_TRUE(trial);
  EXPECT_NEAR((trial->force.row(0).transpose() - recipe.bias).norm(), 0.0, 1e-9);
}

TEST(TrialFromRows, TakesRestOnlyFromTheHoldOfALoadedTrial) {
  auto measured = made_up_trial([] {
    Recipe recipe;
    recipe.bias = {0.6, -0.5};
    return recipe;
  }());
  auto frame = frame_of(measured.report);
  frame.rest = 5.0;
  const auto trial = trial_from_rows(frame, testing::made_up_rig(), measured.rows,
                                     measured.report.onset - measured.report.range.first);
  ASSERT_TRUE(trial);
  EXPECT_EQ(trial->onset, 200);  // the hold of 1 s, not the ramp before it
}

TEST(TrialFromRows, TakesAllRowsOfARecordingAndTheFirstAxisOfAOneAxisRig) {
  RigGeometry ankle;
  ankle.kind = RigKind::kOneAxis;
  ankle.counts_per_unit = {1.0, 1.0};
  ankle.force_calibration = -Eigen::Matrix2d::Identity();
  std::vector<Row> rows(400);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].raw.acquisition_ns = 1'000'000LL * static_cast<std::int64_t>(i);
    rows[i].raw.encoder_count = {i % 2 == 0 ? 0.01 : -0.01, 0.0};
    rows[i].raw.force_V = {i % 2 == 0 ? -2.0 : 4.0, 0.0};
  }
  TrialFrame frame;
  frame.number = 4;
  frame.kind = TrialKind::kRecording;
  frame.sample_rate = 1000.0;
  const auto trial = trial_from_rows(frame, ankle, rows, 0);
  ASSERT_TRUE(trial) << trial.error().message;
  EXPECT_TRUE(trial->is_continuous);
  EXPECT_EQ(trial->axes(), 1);
  EXPECT_EQ(trial->samples(), 400);
  EXPECT_DOUBLE_EQ(trial->displacement(0, 0), 0.01);
  EXPECT_DOUBLE_EQ(trial->force(0, 0), 3.0);  // -(-2) less the mean of -(1)
}

TEST(TrialFromRows, RefusesMissingRowsAndNamesTheFirst) {
  auto measured = made_up_trial({});
  measured.rows[250].is_missing = true;
  const auto trial = convert_all(measured);
  ASSERT_FALSE(trial);
  EXPECT_EQ(trial.error().code, ErrorCode::kDataLoss);
  EXPECT_THAT(trial.error().message, HasSubstr("row 250 is missing"));
}

TEST(TrialFromRows, KeepsTheMissingRowsOfARecordingMarked) {
  RigGeometry ankle;
  ankle.kind = RigKind::kOneAxis;
  ankle.counts_per_unit = {1.0, 1.0};
  ankle.force_calibration = Eigen::Matrix2d::Identity();
  std::vector<Row> rows(400);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].raw.acquisition_ns = 1'000'000LL * static_cast<std::int64_t>(i);
    rows[i].raw.encoder_count = {i % 2 == 0 ? 0.01 : -0.01, 0.0};
    rows[i].raw.force_V = {1.0, 0.0};
  }
  Row placeholder;
  placeholder.is_missing = true;
  rows[100] = rows[101] = placeholder;
  TrialFrame frame;
  frame.kind = TrialKind::kRecording;
  frame.sample_rate = 1000.0;
  const auto trial = trial_from_rows(frame, ankle, rows, 0);
  ASSERT_TRUE(trial) << trial.error().message;
  ASSERT_EQ(trial->is_missing.size(), 400U);
  EXPECT_TRUE(trial->is_missing[100] && trial->is_missing[101] && !trial->is_missing[102]);
  EXPECT_NEAR(trial->displacement(0, 0), 0.01, 1e-12);
  EXPECT_FALSE(trial_from_rows(frame, ankle, std::vector<Row>(50, placeholder), 0)) << "no row at all";
}

TEST(TrialFromRows, CommandThatIsNotKnownIsNone) {
  auto measured = made_up_trial({});
  EXPECT_EQ(convert_all(measured)->commanded.rows(), convert_all(measured)->samples());
  for (Row& row : measured.rows) row.commanded = {std::nan(""), std::nan("")};
  EXPECT_EQ(convert_all(measured)->commanded.rows(), 0);
}

TEST(TrialFromRows, IsNotDisturbedByWhatIsMissingOnTheWayBack) {
  auto measured = made_up_trial({});
  measured.rows.back().is_missing = true;
  EXPECT_TRUE(convert_all(measured));
}

TEST(TrialFromRows, MarksAClippedSensor) {
  auto measured = made_up_trial({});
  EXPECT_FALSE(convert_all(measured)->is_clipped);
  measured.rows[300].is_saturated = true;
  EXPECT_TRUE(convert_all(measured)->is_clipped);
}

TEST(TrialFromRows, RefusesARateThatCannotBe) {
  auto measured = made_up_trial({});
  measured.report.sample_rate = 0.0;
  const auto trial = convert_all(measured);
  ASSERT_FALSE(trial);
  EXPECT_THAT(trial.error().message, HasSubstr("sample rate 0 Hz is not allowed; expected more than 0 Hz"));
}

}  // namespace
}  // namespace tonus::identification
