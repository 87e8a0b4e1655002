#include "analysis_service/impedance/trial.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace tonus::impedance {
namespace {

constexpr double kPeriod = 0.005;

std::vector<EndpointSample> samples(std::size_t count) {
  std::vector<EndpointSample> all;
  for (std::size_t k = 0; k < count; ++k) {
    const auto t = static_cast<double>(k);
    all.push_back({static_cast<std::int64_t>(5'000'000 * k), {0.1 + 0.001 * t, 0.4}, {1.0, 2.0 - 0.5 * t}});
  }
  return all;
}

Preparation preparation() {
  Preparation p;
  p.sample_period = kPeriod;
  return p;
}

TEST(PrepareTrial, MeasuresDisplacementAndForceFromTheRestBeforeTheOnset) {
  const Trial trial = prepare_trial(7, samples(10), 3, preparation()).value();
  EXPECT_EQ(trial.number, 7U);
  EXPECT_EQ(trial.onset, 3);
  EXPECT_EQ(trial.axes(), 2);
  // Rest: x = 0.1, 0.101, 0.102 m, mean 0.101; fy = 2, 1.5, 1 N, mean 1.5.
  EXPECT_NEAR(trial.displacement(9, 0), 0.008, 1e-15);
  EXPECT_NEAR(trial.displacement(9, 1), 0.0, 1e-15);
  EXPECT_NEAR(trial.force(9, 0), 0.0, 1e-15);
  EXPECT_NEAR(trial.force(9, 1), -4.0, 1e-15);
}

TEST(PrepareTrial, KeepsTheBiasForceOfALoadedTrial) {
  Preparation loaded = preparation();
  loaded.is_force_tared = false;
  const Trial trial = prepare_trial(1, samples(10), 3, loaded).value();
  EXPECT_EQ(trial.force(0, 0), 1.0);
  EXPECT_EQ(trial.force(9, 1), -2.5);
}

TEST(PrepareTrial, UsesNoMoreRestThanAskedFor) {
  Preparation brief = preparation();
  brief.rest = 2 * kPeriod;
  const Trial trial = prepare_trial(1, samples(10), 6, brief).value();
  EXPECT_EQ(trial.onset, 2);
  EXPECT_EQ(trial.samples(), 6);
  EXPECT_NEAR(trial.displacement(0, 0), -0.0005, 1e-15);
}

TEST(PrepareTrial, KeepsTheCommandBesideTheSamplesItBelongsTo) {
  std::vector<Eigen::Vector2d> commanded(10, Eigen::Vector2d::Zero());
  commanded[6] = {0.005, 0.0};
  Preparation brief = preparation();
  brief.rest = 2 * kPeriod;
  const Trial trial = prepare_trial(1, samples(10), 6, brief, commanded).value();
  EXPECT_EQ(trial.commanded.rows(), trial.samples());
  EXPECT_EQ(trial.commanded(trial.onset, 0), 0.005);
}

TEST(PrepareTrial, RefusesAGap) {
  auto gap = samples(10);
  for (std::size_t k = 5; k < 10; ++k) gap[k].acquisition_ns += 5'000'000;
  const auto result = prepare_trial(1, gap, 3, preparation());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kDataLoss);
  EXPECT_EQ(result.error().message, "trial: sample 5 comes 0.01 s after the one before it; expected 0.005 s");
}

TEST(PrepareTrial, RefusesAValueThatIsNotFinite) {
  auto bad = samples(10);
  bad[4].f_S.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(prepare_trial(1, bad, 3, preparation()).error().message, "trial: sample 4 is not finite");
}

TEST(PrepareTrial, RefusesAnOnsetWithoutRestOrBeyondTheEnd) {
  EXPECT_EQ(prepare_trial(4, samples(10), 0, preparation()).error().message,
            "trial 4: onset at sample 0 is not allowed; expected 1 to 9");
  EXPECT_EQ(prepare_trial(4, samples(10), 10, preparation()).error().message,
            "trial 4: onset at sample 10 is not allowed; expected 1 to 9");
}

TEST(PrepareTrial, RefusesAPreparationOutsideItsLimits) {
  Preparation p = preparation();
  p.axes = 3;
  EXPECT_EQ(validate(p).error().message, "preparation: axes: 3 is not allowed; expected 1 or 2");
  p = preparation();
  p.handle_mass = -0.1;
  EXPECT_EQ(validate(p).error().message,
            "preparation: handle mass: -0.1 is not allowed; expected 0 kg or more");
  p = preparation();
  p.rest = 0.0;
  EXPECT_FALSE(validate(p));
}

TEST(PrepareRecord, TakesTheMeansOfTheWholeRecordAway) {
  Preparation one_axis = preparation();
  one_axis.axes = 1;
  const Trial record = prepare_record(1, samples(11), one_axis).value();
  EXPECT_TRUE(record.is_continuous);
  EXPECT_EQ(record.axes(), 1);
  EXPECT_NEAR(record.displacement.col(0).mean(), 0.0, 1e-15);
  EXPECT_NEAR(record.displacement(10, 0), 0.005, 1e-15);
}

TEST(Clipping, IsSeenInVoltsAtTheLimit) {
  std::vector<RawSample> raw(5);
  EXPECT_FALSE(is_clipped(raw, 10.0));
  raw[3].force_V[1] = -10.0;
  EXPECT_TRUE(is_clipped(raw, 10.0));
}

}  // namespace
}  // namespace tonus::impedance
