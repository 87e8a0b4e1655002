// Measured ankle records (TONUS_DATA_DIR/ankle), taken the way that the service takes a replayed recording.

#include <array>
#include <cstdlib>
#include <filesystem>
#include <gmock/gmock.h>
#include <string>

#include "analysis_service/identification/identification_core.hpp"
#include "services/recording/dataset.hpp"
#include "tests/support/made_up_trial/made_up_trial.hpp"

namespace tonus::identification {
namespace {

MeasuredTrial trial_of(const recording::Recording& record) {
  MeasuredTrial trial;
  TrialReport& report = trial.report;
  const auto run = static_cast<std::uint32_t>(record.run);
  report.plan.trial = trial_id(testing::made_up_session(), run);
  report.plan.session = testing::made_up_session();
  report.plan.rig = testing::made_up_rig_id();
  report.plan.attempt = run;
  report.plan.kind = TrialKind::kRecording;
  report.plan.posture = "run " + std::to_string(run);
  report.plan.posture_index = run;
  report.sample_rate = record.sampling_frequency;
  report.range = {0, record.rows.size()};
  report.epoch = run;
  for (std::size_t i = 0; i < record.rows.size(); ++i) {
    Row row;
    row.raw = record.rows[i].raw;
    row.raw.acquisition_ns = recording::row_time_ns(record, i);
    row.is_missing = record.rows[i].is_missing;
    row.phase = Phase::kPerturbing;
    trial.rows.push_back(row);
  }
  return trial;
}

TEST(AnkleRecords, GiveTheOrderOfTheirReadmeAndTheNumbersOfAnIndependentProgram) {
  const char* data = std::getenv("TONUS_DATA_DIR");
  if (data == nullptr || !std::filesystem::exists(std::filesystem::path(data) / "ankle")) {
    GTEST_SKIP() << "TONUS_DATA_DIR does not name a folder with ankle/";
  }
  auto records = recording::read_dataset(std::filesystem::path(data) / "ankle");
  ASSERT_TRUE(records) << records.error().message;
  ASSERT_EQ(records->size(), 5U);

  CoreSettings settings;
  settings.book.analyses[0].record_method = impedance::Method::kStateVariable;
  settings.book.analyses[0].natural_frequency = 30.0;
  settings.book.analyses[0].damping_ratio = 0.1;
  IdentificationCore core(settings);
  core.set_session(testing::made_up_session());
  // I, B, K by run: reference/ankle_state_variable.py, an independent program on the same records.
  const double reference[6][3] = {{},
                                  {0.0174905449521, 1.25711313649, 105.129529498},
                                  {0.0171265007478, 0.659017051817, 104.903870605},
                                  {0.0147589806156, 0.76734108636, 60.359941301},
                                  {0.0148189153796, 1.10680351426, 159.84629692},
                                  {0.0170773638786, 1.05626145115, 183.722558077}};
  std::array<double, 6> stiffness{};
  for (auto& record : *records) {
    ASSERT_TRUE(
        recording::state_force_sign(record, -1));  // the reaction of the ankle on the servo, says the README
    const auto trial = trial_of(record);
    core.set_rig(testing::made_up_rig_id(), record.rig, record.sampling_frequency);
    for (const auto& block : testing::blocks_of(trial, 256)) core.add(block);
    core.add(trial.report, Clock::TimePoint());
    const auto judged = core.advance(Clock::TimePoint(), true);
    ASSERT_EQ(judged.verdicts.size(), 1U);
    EXPECT_TRUE(judged.verdicts[0].verdict.is_valid) << judged.verdicts[0].verdict.detail;
    const auto output = core.advance(Clock::TimePoint(), true);
    ASSERT_EQ(output.estimates.size(), 1U);
    const auto& found = output.estimates[0].estimate;
    ASSERT_EQ(found.axes, 1) << output.estimates[0].refusal;
    EXPECT_GT(found.value.M(0, 0), 0.014) << "run " << record.run;
    EXPECT_LT(found.value.M(0, 0), 0.021) << "run " << record.run;
    EXPECT_GT(found.std.K(0, 0), 0.0);
    const double* expected = reference[record.run];
    EXPECT_NEAR(found.value.M(0, 0), expected[0], 1e-9 * expected[0]) << "run " << record.run;
    EXPECT_NEAR(found.value.B(0, 0), expected[1], 1e-9 * expected[1]) << "run " << record.run;
    EXPECT_NEAR(found.value.K(0, 0), expected[2], 1e-9 * expected[2]) << "run " << record.run;
    stiffness[static_cast<std::size_t>(record.run)] = found.value.K(0, 0);
  }
  EXPECT_LT(stiffness[3], stiffness[1]);  // df2 < df
  EXPECT_LT(stiffness[1], stiffness[4]);  // df < df3
  EXPECT_LT(stiffness[2], stiffness[5]);  // pf < pf2
}

}  // namespace
}  // namespace tonus::identification
