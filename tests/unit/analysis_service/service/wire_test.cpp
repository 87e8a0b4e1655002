#include "analysis_service/service/wire.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <set>

#include "analysis_service/identification/conversion.hpp"
#include "tests/support/made_up_trial/made_up_trial.hpp"

namespace tonus::identification {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

v1::RigDescription description() {
  v1::RigDescription wire;
  wire.name("rig");
  wire.kind(v1::RIG_TWO_LINK);
  wire.link_lengths_m({0.30, 0.35});
  wire.encoder_counts_per_unit({1273.0, 1274.0});
  wire.encoder_zero_count({5.0, -6.0});
  wire.encoder_sign({1.0, -1.0});
  wire.force_calibration_N_per_V({4.0, 0.1, 0.2, 5.0});
  wire.force_offset_V({0.01, 0.02});
  wire.force_sensor_angle_rad(0.3);
  wire.force_saturation_V(9.5);
  wire.handle_mass_kg(0.25);
  return wire;
}

TEST(Wire, TakesEveryConstantOfARig) {
  const auto rig = contract::geometry_of(description());
  ASSERT_TRUE(rig);
  EXPECT_EQ(rig->kind, RigKind::kTwoLink);
  EXPECT_EQ(rig->links.l2, 0.35);
  EXPECT_THAT(rig->counts_per_unit, ElementsAre(1273.0, 1274.0));
  EXPECT_THAT(rig->encoder_zero, ElementsAre(5.0, -6.0));
  EXPECT_THAT(rig->encoder_sign, ElementsAre(1.0, -1.0));
  EXPECT_EQ(rig->force_calibration(0, 1), 0.1);
  EXPECT_EQ(rig->force_calibration(1, 0), 0.2);
  EXPECT_EQ(rig->force_offset_V[1], 0.02);
  EXPECT_EQ(rig->force_sensor_angle, 0.3);
  EXPECT_EQ(rig->force_saturation_V, 9.5);
  EXPECT_EQ(rig->handle_mass, 0.25);
}

TEST(Wire, RefusesARigThatCannotBeConvertedWith) {
  auto wire = description();
  wire.force_calibration_N_per_V({1.0, 1.0, 1.0, 1.0});
  ASSERT_FALSE(contract::geometry_of(wire));
  wire = description();
  wire.kind(static_cast<v1::RigKind>(7));
  const auto rig = contract::geometry_of(wire);
  ASSERT_FALSE(rig);
  EXPECT_THAT(rig.error().message, HasSubstr("kind: 7 is not allowed; expected 0 to 2"));
}

TEST(Wire, TakesEveryPartOfASample) {
  v1::RigSample wire;
  wire.acquisition_ns(123);
  wire.encoder_count({1.0, 2.0});
  wire.force_V({3.0, 4.0});
  wire.commanded_m({5.0, 6.0});
  wire.phase(v1::PHASE_BIAS_HOLD);
  wire.flags(1);
  auto row = from_wire(wire);
  EXPECT_EQ(row.raw.acquisition_ns, 123);
  EXPECT_THAT(row.raw.encoder_count, ElementsAre(1.0, 2.0));
  EXPECT_THAT(row.raw.force_V, ElementsAre(3.0, 4.0));
  EXPECT_THAT(row.commanded, ElementsAre(5.0, 6.0));
  EXPECT_EQ(row.phase, Phase::kBiasHold);
  EXPECT_TRUE(row.is_saturated);
  EXPECT_FALSE(row.is_missing);
  wire.flags(2);
  row = from_wire(wire);
  EXPECT_FALSE(row.is_saturated);
  EXPECT_TRUE(row.is_missing);
}

TEST(Wire, TellsEveryPhaseApartAndTakesAnUnknownOneForNone) {
  std::set<Phase> phases;
  v1::RigSample wire;
  for (std::uint8_t phase = v1::PHASE_IDLE; phase <= v1::PHASE_SAFE; ++phase) {
    wire.phase(phase);
    phases.insert(from_wire(wire).phase);
  }
  EXPECT_THAT(phases, SizeIs(v1::PHASE_SAFE + 1));
  wire.phase(200);
  EXPECT_EQ(from_wire(wire).phase, Phase::kSafe);
}

TEST(Wire, TellsEveryDefectApart) {
  std::set<std::uint32_t> reasons;
  for (int defect = 0; defect <= static_cast<int>(Defect::kMusclesActive); ++defect) {
    reasons.insert(to_wire(static_cast<Defect>(defect)));
  }
  EXPECT_THAT(reasons, SizeIs(static_cast<std::size_t>(Defect::kMusclesActive) + 1));
}

TEST(Wire, TellsEveryEndOfATrialApart) {
  std::set<TrialEnd> ends;
  v1::TrialOutcome wire;
  for (std::uint32_t end = v1::TRIAL_COMPLETED; end <= v1::TRIAL_BROKEN_OFF; ++end) {
    wire.end(static_cast<v1::TrialEnd>(end));
    ends.insert(from_wire(wire).end);
  }
  EXPECT_THAT(ends, SizeIs(v1::TRIAL_BROKEN_OFF + 1));
}

TEST(Wire, TakesEveryPartOfAnOutcome) {
  v1::TrialProgram program;
  program.session_id(id_of("s"));
  program.rig_id(id_of("r"));
  program.attempt(3);
  program.planned_index(2);
  program.kind(v1::TRIAL_RECORDING);
  program.posture("distal");
  program.posture_index(1);
  program.posture_m({0.0, 0.52});
  program.shoulder_origin_m({0.05, -0.1});
  program.shoulder_angle_rad(0.2);
  program.set_number(4);
  program.instruction("relax");
  program.bias_N({0.7, -0.1});
  program.bias_hold_s(1.0);
  program.bias_threshold_N(0.1);
  v1::TrialOutcome wire;
  wire.trial_id(id_of("t"));
  wire.program(program);
  wire.epoch(9);
  wire.detail("detail");
  wire.first_sequence(10);
  wire.onset_sequence(20);
  wire.last_sequence(30);
  wire.sample_rate_Hz(200.0);
  const auto report = from_wire(wire);
  EXPECT_EQ(report.plan.trial, id_of("t"));
  EXPECT_EQ(report.plan.session, id_of("s"));
  EXPECT_EQ(report.plan.rig, id_of("r"));
  EXPECT_EQ(report.plan.attempt, 3U);
  EXPECT_EQ(report.plan.planned_index, 2U);
  EXPECT_EQ(report.plan.kind, TrialKind::kRecording);
  EXPECT_EQ(report.plan.posture, "distal");
  EXPECT_EQ(report.plan.posture_index, 1U);
  EXPECT_EQ(report.plan.position, Eigen::Vector2d(0.0, 0.52));
  EXPECT_EQ(report.plan.shoulder.origin, Eigen::Vector2d(0.05, -0.1));
  EXPECT_EQ(report.plan.shoulder.angle, 0.2);
  EXPECT_EQ(report.plan.set, 4);
  EXPECT_EQ(report.plan.instruction, "relax");
  EXPECT_EQ(report.plan.bias, Eigen::Vector2d(0.7, -0.1));
  EXPECT_EQ(report.plan.bias_hold, 1.0);
  EXPECT_EQ(report.plan.bias_threshold, 0.1);
  EXPECT_EQ(report.epoch, 9U);
  EXPECT_EQ(report.detail, "detail");
  EXPECT_EQ(report.range, (SequenceRange{10, 31}));
  EXPECT_EQ(report.onset, 20U);
  EXPECT_EQ(report.sample_rate, 200.0);
}

TEST(Wire, GivesEveryPartOfAVerdict) {
  Verdict verdict;
  verdict.defects = {Defect::kOffTarget, Defect::kGap};
  verdict.detail = "line";
  verdict.measured = {.start_offset = 1,
                      .rest_speed = 2,
                      .rest_force = 3,
                      .excursion = 4,
                      .end_speed = 5,
                      .saturated_rows = 6,
                      .missing_rows = 7};
  const auto report = testing::made_up_trial({}).report;
  const auto wire = to_wire(report, verdict);
  EXPECT_EQ(wire.trial_id(), report.plan.trial);
  EXPECT_EQ(wire.session_id(), report.plan.session);
  EXPECT_EQ(wire.attempt(), 1U);
  EXPECT_FALSE(wire.is_valid());
  EXPECT_THAT(wire.reasons(), ElementsAre(v1::REASON_OFF_TARGET, v1::REASON_GAP));
  EXPECT_EQ(wire.detail(), "line");
  EXPECT_EQ(wire.start_offset_m(), 1);
  EXPECT_EQ(wire.rest_speed_m_per_s(), 2);
  EXPECT_EQ(wire.rest_force_N(), 3);
  EXPECT_EQ(wire.excursion_m(), 4);
  EXPECT_EQ(wire.end_speed_m_per_s(), 5);
  EXPECT_EQ(wire.saturated_samples(), 6U);
  EXPECT_EQ(wire.missing_samples(), 7U);
}

ConditionEstimate estimate_of_made_up_condition(const impedance::Options& options) {
  BookSettings settings;
  settings.analyses = {options};
  ConditionBook book(settings);
  for (const auto& trial : testing::made_up_condition()) {
    const auto converted = trial_from_rows(frame_of(trial.report), testing::made_up_rig(), trial.rows,
                                           trial.report.onset - trial.report.range.first);
    EXPECT_TRUE(book.add_valid(trial.report, *converted));
  }
  return book.identify(book.changed().front()).front();
}

TEST(Wire, GivesMatricesRowByRowWithEllipseCurlAndIntervals) {
  const auto estimate = estimate_of_made_up_condition({});
  const auto wire = to_wire(estimate, {});
  EXPECT_EQ(wire.status(), v1::ESTIMATE_OK);
  EXPECT_EQ(wire.method(), "state_variable");
  EXPECT_EQ(wire.model(), "linear");
  EXPECT_EQ(wire.axes(), 2U);
  EXPECT_EQ(wire.posture(), "reference");
  const auto& k = wire.stiffness_N_per_m();
  EXPECT_EQ(k.value()[1], estimate.estimate.value.K(0, 1));
  EXPECT_EQ(k.value()[2], estimate.estimate.value.K(1, 0));
  EXPECT_EQ(k.standard_error()[2], estimate.estimate.std.K(1, 0));
  EXPECT_LT(k.low95()[0], k.value()[0]);
  EXPECT_GT(k.high95()[0], k.value()[0]);
  EXPECT_TRUE(k.has_ellipse());
  // Ks = [320 55; 55 210]: l = 265 +- sqrt(55^2 + 55^2), 22.5 deg; Za = 5: p_mean = 5 / sqrt(l1 l2).
  const double l1 = 265.0 - 55.0 * std::sqrt(2.0);
  const double l2 = 265.0 + 55.0 * std::sqrt(2.0);
  EXPECT_NEAR(k.shape(), l2 / l1, 0.02 * l2 / l1);
  EXPECT_NEAR(k.size(), 3.14159265 * l1 * l2, 0.02 * 3.14159265 * l1 * l2);
  EXPECT_NEAR(k.orientation_deg(), 22.5, 0.5);
  EXPECT_NEAR(k.curl(), 5.0 / std::sqrt(l1 * l2), 0.005);
  EXPECT_EQ(wire.degrees_of_freedom(), 15.0);
  EXPECT_EQ(wire.trials_used(), 16U);
  ASSERT_THAT(wire.trials(), SizeIs(16));
  EXPECT_EQ(wire.trials()[1].attempt(), 2U);
  EXPECT_EQ(wire.trials()[1].first_sequence(), 2000U);
  EXPECT_EQ(wire.trials()[1].onset_sequence(), 2240U);  // 0.2 s of centring and 1 s of waiting
  EXPECT_EQ(wire.natural_frequency_Hz(), estimate.estimate.natural_frequency);
  EXPECT_EQ(wire.window_s(), 1.0);
}

TEST(Wire, GivesZerosForWhatAModelHasNot) {
  impedance::Options options;
  options.model = impedance::Model::kNoDamping;
  auto wire = to_wire(estimate_of_made_up_condition(options), {});
  EXPECT_THAT(wire.damping_Ns_per_m().value(), ElementsAre(0.0, 0.0, 0.0, 0.0));
  EXPECT_FALSE(wire.damping_Ns_per_m().has_ellipse());
  EXPECT_TRUE(wire.stiffness_N_per_m().has_ellipse());
  options.model = impedance::Model::kCoriolis;
  wire = to_wire(estimate_of_made_up_condition(options), {});
  EXPECT_THAT(wire.damping_Ns_per_m().value(), ElementsAre(0.0, 0.0, 0.0, 0.0));
}

TEST(Wire, GivesLagBandUnitsAndChecksOfARecord) {
  ConditionEstimate estimate;
  impedance::Estimate& found = estimate.estimate;
  found.method = impedance::Method::kSpectral;
  found.axes = 1;
  found.status = impedance::Status::kSuspect;
  found.explained = impedance::AxisVector::Constant(1, 0.93);
  found.force_lag = impedance::AxisVector::Constant(1, 0.004);
  found.force_lag_low = impedance::AxisVector::Constant(1, 0.003);
  found.force_lag_high = impedance::AxisVector::Constant(1, 0.005);
  found.band_low = 1.5;
  found.band_high = 40.0;
  found.segment_duration = 2.0;
  found.units = 15;
  found.checks = {{impedance::FitTest::kCoherence, 0.9, 0.5, true},
                  {impedance::FitTest::kFriction, 0.3, 0.02, false}};
  found.reasons = {impedance::Reason::kFriction};
  found.details[impedance::Reason::kFriction] = "30 % of the force";
  const auto wire = to_wire(estimate, {"rad", "N m"});
  EXPECT_EQ(wire.method(), "spectral");
  EXPECT_EQ(wire.explained_share(), 0.93);
  EXPECT_EQ(wire.lag_s()[0], 0.004);
  EXPECT_EQ(wire.lag_low95_s()[0], 0.003);
  EXPECT_EQ(wire.lag_high95_s()[0], 0.005);
  EXPECT_FALSE(std::isfinite(wire.lag_s()[1])) << "there is no second axis";
  EXPECT_EQ(wire.band_low_Hz(), 1.5);
  EXPECT_EQ(wire.band_high_Hz(), 40.0);
  EXPECT_EQ(wire.window_s(), 2.0);
  EXPECT_EQ(wire.independent_units(), 15U);
  EXPECT_EQ(wire.degrees_of_freedom(), 14.0);
  ASSERT_THAT(wire.checks(), SizeIs(2));
  EXPECT_EQ(wire.checks()[1].test(), v1::FIT_FRICTION);
  EXPECT_EQ(wire.checks()[1].value(), 0.3);
  EXPECT_EQ(wire.checks()[1].limit(), 0.02);
  EXPECT_FALSE(wire.checks()[1].passed());
  EXPECT_THAT(wire.reasons(), ElementsAre("friction: 30 % of the force"));
}

TEST(Wire, GivesReasonsWithinTheirBound) {
  ConditionEstimate estimate;
  estimate.refusal = "options: window: 0 s is not allowed; expected more than 0 s";
  for (std::uint32_t i = 0; i < 40; ++i) {
    estimate.estimate.trials_rejected.push_back({i, impedance::Reason::kShortTrial});
  }
  const auto wire = to_wire(estimate, {"rad", "N m"});
  EXPECT_EQ(wire.status(), v1::ESTIMATE_UNDETERMINED);
  ASSERT_THAT(wire.reasons(), SizeIs(16));
  EXPECT_EQ(wire.reasons()[0], estimate.refusal);
  EXPECT_EQ(wire.reasons()[15], "and 26 more");
  EXPECT_EQ(wire.trials_rejected(), 40U);
  EXPECT_EQ(wire.displacement_unit(), "rad");
  EXPECT_EQ(wire.force_unit(), "N m");
}

TEST(Wire, NamesAnEstimateByConditionMethodAndModel) {
  Condition condition;
  condition.session = id_of("s");
  condition.posture_index = 2;
  condition.set = 3;
  condition.bias = {0.7, -0.0};
  condition.instruction = "relax";
  EXPECT_EQ(estimate_id(condition, impedance::Method::kLowpass, impedance::Model::kLinear),
            id_of(to_hex(id_of("s")) + "/2/3:0.700,0.000/relax/lowpass/linear"));
}

}  // namespace
}  // namespace tonus::identification
