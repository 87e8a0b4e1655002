// Refusals of identify_recordings, each with its own reason, on recordings of the simulated rig.
#include "analysis_service/offline/offline.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/support/simulated_study/simulated_study.hpp"

namespace tonus::identification {
namespace {

using Estimates = std::vector<OfflineEstimate>;
using Reasons = std::vector<std::string>;

/// One sound posture, raw counts and volts; made once.
const recording::Recording& raw() {
  static const recording::Recording record =
      simulated::measure(simulation::Profile{}, simulated::published_postures()[0]).value();
  return record;
}

/// The same in converted channels: endpoint and force in the shoulder frame.
recording::Recording converted() {
  recording::Recording record = raw();
  record.is_raw = false;
  for (recording::Row& row : record.rows) {
    const EndpointSample sample = tonus::convert(record.rig, record.shoulder, row.raw);
    row.raw.encoder_count = {sample.p_SE[0], sample.p_SE[1]};
    row.raw.force_V = {sample.f_S[0], sample.f_S[1]};
  }
  const double handle_mass = record.rig.handle_mass;
  record.rig = {};
  record.rig.kind = RigKind::kCartesian;
  record.rig.counts_per_unit = {1.0, 1.0};
  record.rig.force_calibration.setIdentity();
  record.rig.force_saturation_V = std::numeric_limits<double>::infinity();
  record.rig.handle_mass = handle_mass;
  return record;
}

Estimates identify(const recording::Recording& record, const impedance::Options& options = {}) {
  return identify_recordings({&record, 1}, {options}).value();
}

v1::Estimate only(const Estimates& estimates) {
  EXPECT_EQ(estimates.size(), 1U);
  return estimates.at(0).estimate;
}

bool has(const v1::Estimate& estimate, const std::string& reason) {
  return std::ranges::find(estimate.reasons(), reason) != estimate.reasons().end();
}

std::size_t row_at(const recording::Recording& record, double time) {
  return static_cast<std::size_t>(std::llround(time * record.sampling_frequency));
}

TEST(IdentifyRecordings, FindsNothingAmissInASoundRecordingRawOrConverted) {
  const auto of_raw = only(identify(raw()));
  const auto of_converted = only(identify(converted()));
  EXPECT_EQ(of_raw.status(), v1::ESTIMATE_OK) << (of_raw.reasons().empty() ? "" : of_raw.reasons()[0]);
  EXPECT_EQ(of_converted.status(), v1::ESTIMATE_OK);
  EXPECT_EQ(of_raw.trials_used(), 16U);
  for (std::size_t i = 0; i < 4; ++i) {
    const double value = of_raw.stiffness_N_per_m().value()[i];
    EXPECT_NEAR(of_converted.stiffness_N_per_m().value()[i], value, 1e-9 * std::abs(value));
  }
}

TEST(IdentifyRecordings, LeavesOutATrialFlaggedInvalidWithTheRecordedReason) {
  auto record = raw();
  record.events[2].is_valid = false;
  record.events[2].reason = "the subject spoke";
  const auto estimates = identify(record);
  ASSERT_EQ(estimates.at(0).left_out.size(), 1U);
  EXPECT_EQ(estimates[0].left_out[0].trial, record.events[2].trial);
  EXPECT_EQ(estimates[0].left_out[0].reason, "the subject spoke");
  EXPECT_EQ(estimates[0].estimate.trials_used(), 15U);
  EXPECT_EQ(estimates[0].estimate.trials_rejected(), 1U);
}

TEST(IdentifyRecordings, DoesNotNeedTheCommand) {
  auto record = raw();
  const auto with = only(identify(record));
  record.commanded.clear();
  const auto without = only(identify(record));
  EXPECT_EQ(without.status(), v1::ESTIMATE_OK) << (without.reasons().empty() ? "" : without.reasons()[0]);
  EXPECT_EQ(without.stiffness_N_per_m().value(), with.stiffness_N_per_m().value());
}

/// One axis, 60 s at 500 Hz: motion of random phases in 1 to 20 Hz, force of M 1.2, B 12, K 900.
recording::Recording stochastic() {
  recording::Recording record;
  record.participant.id = "sub-01";
  record.sampling_frequency = 500.0;
  record.rig.kind = RigKind::kOneAxis;
  record.rig.counts_per_unit = {1.0, 1.0};
  record.rig.force_calibration.setIdentity();
  record.rig.force_saturation_V = std::numeric_limits<double>::infinity();
  record.rows.resize(30'000);
  double phase = 0.3;
  for (double hz = 1.013; hz < 20.0; hz += 0.0371) {
    phase = std::fmod(phase * 7.31 + 1.7, 6.28);
    const double w = 2.0 * 3.14159265358979323846 * hz;
    for (std::size_t i = 0; i < record.rows.size(); ++i) {
      const double angle = w * static_cast<double>(i) / 500.0 + phase;
      record.rows[i].raw.encoder_count[0] += 1e-3 * std::cos(angle);
      record.rows[i].raw.force_V[0] +=
          1e-3 * ((900.0 - w * w * 1.2) * std::cos(angle) - w * 12.0 * std::sin(angle));
    }
  }
  recording::PerturbationEvent event;
  event.duration_s = 60.0;
  record.events = {event};
  return record;
}

TEST(IdentifyRecordings, ContinuousEventIsItsOwnRowsAndNoOthers) {
  auto record = stochastic();
  record.events[0].onset_s = 10.0;
  record.events[0].duration_s = 30.0;
  for (std::size_t i = 0; i < record.rows.size(); ++i) {  // another arm outside the event
    if (i < 5000 || i >= 20'000) record.rows[i].raw.force_V[0] *= 2.0;
  }
  const auto found = only(identify(record));
  EXPECT_EQ(found.method(), "spectral");
  EXPECT_EQ(found.model(), "linear");
  EXPECT_EQ(found.status(), v1::ESTIMATE_OK) << (found.reasons().empty() ? "" : found.reasons()[0]);
  EXPECT_EQ(found.samples(), 15'000U);
  EXPECT_NEAR(found.stiffness_N_per_m().value()[0], 900.0, 9.0);
  EXPECT_NEAR(found.mass_kg().value()[0], 1.2, 0.012);
}

TEST(IdentifyRecordings, FrictionOfARecordIsAParameterOfItsModelWithUnits) {
  auto record = stochastic();
  for (std::size_t i = 1; i + 1 < record.rows.size(); ++i) {
    const double step = record.rows[i + 1].raw.encoder_count[0] - record.rows[i - 1].raw.encoder_count[0];
    record.rows[i].raw.force_V[0] += step > 0.0 ? 4.0 : -4.0;
  }
  EXPECT_EQ(only(identify(record)).status(), v1::ESTIMATE_SUSPECT);
  impedance::Options options;
  options.model = impedance::Model::kAutomatic;
  const auto found = only(identify(record, options));
  EXPECT_EQ(found.model(), "friction");
  EXPECT_EQ(found.status(), v1::ESTIMATE_OK) << (found.reasons().empty() ? "" : found.reasons()[0]);
  EXPECT_NE(found.compared_models().find("linear: refused; friction: accepted"), std::string::npos)
      << found.compared_models();
  ASSERT_EQ(found.parameters().size(), 1U);
  EXPECT_EQ(found.parameters()[0].name(), "friction");
  EXPECT_EQ(found.parameters()[0].unit(), "N");
  EXPECT_NEAR(found.parameters()[0].value(), 4.0, 0.2);
  EXPECT_NEAR(found.damping_Ns_per_m().value()[0], 12.0, 1.2);
}

TEST(IdentifyRecordings, ModelsOfRecordsAreRefusedForPerturbationsByName) {
  impedance::Options options;
  options.model = impedance::Model::kReflex;
  const auto estimate = only(identify(raw(), options));
  EXPECT_EQ(estimate.status(), v1::ESTIMATE_UNDETERMINED);
  ASSERT_FALSE(estimate.reasons().empty());
  EXPECT_NE(estimate.reasons()[0].find("reflex"), std::string::npos) << estimate.reasons()[0];
}

TEST(IdentifyRecordings, RowsOfContinuousEventsAreUsedOnce) {
  auto record = stochastic();
  record.events.push_back(record.events[0]);
  record.events[1].trial = 2;
  record.events[1].onset_s = 20.0;
  record.events[1].duration_s = 10.0;
  const auto estimates = identify(record);
  EXPECT_EQ(only(estimates).samples(), 30'000U);
  ASSERT_EQ(estimates[0].left_out.size(), 1U);
  EXPECT_NE(estimates[0].left_out[0].reason.find("overlap"), std::string::npos);
}

TEST(IdentifyRecordings, GapsOfAContinuousRecordCostOnlyTheirSegments) {
  auto record = stochastic();
  for (const std::size_t row : {7000, 15'000, 15'001}) record.rows[row].is_missing = true;
  const auto found = only(identify(record));
  EXPECT_EQ(found.status(), v1::ESTIMATE_OK) << (found.reasons().empty() ? "" : found.reasons()[0]);
  EXPECT_EQ(found.samples(), 29'997U);
}

TEST(IdentifyRecordings, ForceSignThatIsWrongIsNamedWithItsOption) {
  auto record = stochastic();
  record.rig.force_calibration(0, 0) = -1.0;
  const auto found = only(identify(record));
  EXPECT_EQ(found.status(), v1::ESTIMATE_SUSPECT);
  ASSERT_FALSE(found.reasons().empty());
  EXPECT_NE(found.reasons()[0].find("--force-sign"), std::string::npos) << found.reasons()[0];
}

TEST(IdentifyRecordings, LeavesOutATrialWithAGap) {
  auto record = raw();
  const std::size_t row = row_at(record, record.events[4].onset_s + 0.3);
  for (std::size_t i = row; i < row + 3; ++i) record.rows[i].is_missing = true;
  const auto estimates = identify(record);
  ASSERT_EQ(estimates.at(0).left_out.size(), 1U);
  EXPECT_EQ(estimates[0].left_out[0].trial, record.events[4].trial);
  EXPECT_EQ(estimates[0].left_out[0].reason, "gap: 3 of 551 rows missing, allowed none");
  EXPECT_EQ(estimates[0].estimate.trials_used(), 15U);
}

TEST(IdentifyRecordings, LeavesOutATrialWithSaturatedForce) {
  auto record = raw();
  record.rows[row_at(record, record.events[7].onset_s + 0.2)].raw.force_V[1] = -record.rig.force_saturation_V;
  const auto estimates = identify(record);
  ASSERT_EQ(estimates.at(0).left_out.size(), 1U);
  EXPECT_EQ(estimates[0].left_out[0].trial, record.events[7].trial);
  EXPECT_EQ(estimates[0].left_out[0].reason,
            "saturated: 1 rows with the force sensor at its limit, allowed none");
  EXPECT_EQ(estimates[0].estimate.trials_used(), 15U);
}

TEST(IdentifyRecordings, KeepsTheNumbersOfTheOtherTrialsWhenSomeAreLeftOut) {
  auto flagged = raw();
  flagged.events[3].is_valid = false;
  auto shorter = raw();
  shorter.events.erase(shorter.events.begin() + 3);
  EXPECT_EQ(only(identify(flagged)).mass_kg().value(), only(identify(shorter)).mass_kg().value());
}

TEST(IdentifyRecordings, IsUndeterminedAndSaysWhyWhereEveryTrialIsLeftOut) {
  auto record = raw();
  for (auto& event : record.events) event.is_valid = false;
  const auto estimates = identify(record);
  ASSERT_EQ(estimates.size(), 1U);
  EXPECT_EQ(estimates[0].estimate.status(), v1::ESTIMATE_UNDETERMINED);
  EXPECT_EQ(estimates[0].estimate.reasons(), Reasons{"too_few_trials"});
  EXPECT_EQ(estimates[0].estimate.posture(), "reference");
  EXPECT_EQ(estimates[0].estimate.axes(), 2U);
  EXPECT_EQ(estimates[0].left_out.size(), 16U);
  EXPECT_EQ(estimates[0].left_out[0].reason, "flagged invalid");
}

TEST(IdentifyRecordings, SuspectsANegativeStiffnessHoweverWellItFits) {
  auto record = converted();
  record.rig.force_calibration *= -1.0;  // the force of the arm on the handle
  const auto sound = only(identify(converted()));
  const auto estimate = only(identify(record));
  EXPECT_NEAR(estimate.sigma_N()[0], sound.sigma_N()[0], 1e-9);  // fits as well as the sound one
  EXPECT_EQ(estimate.status(), v1::ESTIMATE_SUSPECT);
  ASSERT_FALSE(estimate.reasons().empty());
  EXPECT_NE(estimate.reasons()[0].find("--force-sign"), std::string::npos);
}

TEST(IdentifyRecordings, SuspectsCollinearForceChannels) {
  auto record = converted();
  for (auto& row : record.rows) row.raw.force_V[1] = -0.7 * row.raw.force_V[0];
  const auto estimate = only(identify(record));
  EXPECT_NE(estimate.status(), v1::ESTIMATE_OK);
  EXPECT_TRUE(has(estimate, "collinear_force"));
}

TEST(IdentifyRecordings, IsUndeterminedWithASingleDirection) {
  auto record = raw();
  std::erase_if(record.events,
                [](const auto& event) { return std::fmod(*event.direction_deg, 180.0) != 45.0; });
  ASSERT_EQ(record.events.size(), 4U);
  const auto estimate = only(identify(record));
  EXPECT_EQ(estimate.status(), v1::ESTIMATE_UNDETERMINED);
  EXPECT_EQ(estimate.reasons(), Reasons{"single_direction"});
}

TEST(IdentifyRecordings, SuspectsAForceChannelThirtyMillisecondsLate) {
  for (const std::size_t channel : {0U, 1U}) {
    for (auto record : {raw(), converted()}) {
      const auto rows = record.rows;
      for (std::size_t i = 6; i < rows.size(); ++i)  // 6 samples of 5 ms
        record.rows[i].raw.force_V[channel] = rows[i - 6].raw.force_V[channel];
      const auto estimate = only(identify(record));
      EXPECT_EQ(estimate.status(), v1::ESTIMATE_SUSPECT)
          << "channel " << channel << ", raw " << record.is_raw;
      ASSERT_FALSE(estimate.reasons().empty());
      EXPECT_EQ(estimate.reasons().front().substr(0, 47), "force_shifted: the force is 30.00 ms later than")
          << "channel " << channel << ", raw " << record.is_raw;
    }
  }
}

TEST(IdentifyRecordings, SuspectsASensorThatClipsBelowItsStatedLimit) {
  auto record = converted();
  double largest = 0.0;
  for (const auto& row : record.rows) largest = std::max(largest, std::abs(row.raw.force_V[1]));
  for (auto& row : record.rows)
    row.raw.force_V[1] = std::clamp(row.raw.force_V[1], -0.5 * largest, 0.5 * largest);
  const auto estimate = only(identify(record));
  EXPECT_EQ(estimate.status(), v1::ESTIMATE_SUSPECT);
  EXPECT_TRUE(has(estimate, "clipped_force"));
}

TEST(IdentifyRecordings, LeavesOutEveryTrialThatASensorClipsAtItsLimit) {
  auto record = raw();
  double largest = 0.0;
  for (const auto& row : record.rows) largest = std::max(largest, std::abs(row.raw.force_V[1]));
  record.rig.force_saturation_V = 0.5 * largest;
  for (auto& row : record.rows)
    row.raw.force_V[1] = std::clamp(row.raw.force_V[1], -0.5 * largest, 0.5 * largest);
  const auto estimates = identify(record);
  ASSERT_FALSE(estimates.at(0).left_out.empty());
  for (const auto& trial : estimates[0].left_out)
    EXPECT_TRUE(trial.reason.starts_with("saturated: ")) << trial.reason;
}

/// Sound but for one trial, whose hand is 8 mm beside its place.
recording::Recording with_a_trial_off_target() {
  auto record = converted();
  const recording::Stretch stretch = recording::stretch_of(record, record.events[3]);
  for (std::size_t i = stretch.first; i <= stretch.last; ++i) record.rows[i].raw.encoder_count[0] += 0.008;
  return record;
}

TEST(IdentifyRecordings, JudgesTrialsByTheLimitsOfLiveOnes) {
  const auto record = with_a_trial_off_target();
  const auto estimates = identify(record);
  ASSERT_EQ(estimates.at(0).left_out.size(), 1U);
  EXPECT_EQ(estimates[0].left_out[0].trial, record.events[3].trial);
  EXPECT_TRUE(estimates[0].left_out[0].reason.starts_with("off target: hand "))
      << estimates[0].left_out[0].reason;
  EXPECT_EQ(estimates[0].estimate.trials_used(), 15U);
}

TEST(IdentifyRecordings, JudgesByTheLimitsThatWereChosen) {
  const auto record = with_a_trial_off_target();
  JudgeChoice wide;
  wide.start_offset = 0.010;
  JudgeChoice reaching;
  reaching.is_reaching = true;
  for (const JudgeChoice& choice : {wide, reaching}) {
    const auto estimates = identify_recordings({&record, 1}, {impedance::Options{}}, choice).value();
    EXPECT_TRUE(estimates.at(0).left_out.empty());
    EXPECT_EQ(estimates[0].estimate.trials_used(), 16U);
  }
}

TEST(IdentifyRecordings, APlaceThatIsNotStatedIsNotTheOrigin) {
  auto record = converted();
  record.posture_position.reset();
  const auto estimates = identify(record);
  EXPECT_TRUE(estimates.at(0).left_out.empty()) << estimates[0].left_out[0].reason;
  EXPECT_EQ(only(estimates).status(), v1::ESTIMATE_OK);
}

TEST(JudgeChoice, RotaryRigsAreNotHeldToMetresUnlessALimitIsChosen) {
  JudgeChoice choice;
  EXPECT_FALSE(std::isfinite(choice.limits(true).excursion));
  EXPECT_EQ(choice.limits(false).excursion, JudgeLimits{}.excursion);
  choice.excursion = 0.2;
  EXPECT_EQ(choice.limits(true).excursion, 0.2);
}

TEST(IdentifyRecordings, RefusesARigThatCannotBeConvertedWith) {
  auto record = raw();
  record.rig.links.l1 = 0.0;
  const auto estimates = identify_recordings({&record, 1}, {impedance::Options{}});
  ASSERT_FALSE(estimates);
  EXPECT_EQ(estimates.error().code, ErrorCode::kInvalidArgument);
  EXPECT_TRUE(estimates.error().message.starts_with("sub-01 run 1 (reference): "))
      << estimates.error().message;
}

TEST(IdentifyRecordings, GivesEveryAnalysisOfEveryRecordingInTheirOrder) {
  const std::vector<recording::Recording> records(5, raw());
  std::vector<impedance::Options> analyses(2);
  analyses[1].method = impedance::Method::kLowpass;
  const auto estimates = identify_recordings(records, analyses).value();
  ASSERT_EQ(estimates.size(), 10U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(estimates[i].estimate.posture_index(), i / 2);
    EXPECT_EQ(estimates[i].estimate.method(), i % 2 == 0 ? "state_variable" : "lowpass");
    EXPECT_EQ(estimates[i].estimate.damping_Ns_per_m().value(),
              estimates[i % 2].estimate.damping_Ns_per_m().value());
  }
}

}  // namespace
}  // namespace tonus::identification
