#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "analysis_service/impedance/identification.hpp"
#include "tests/campaigns/record_kinds.hpp"

namespace tonus::impedance::test {
namespace {

campaigns::DrawnRecords drawn(const std::string& kind) {
  const auto& kinds = campaigns::record_kinds();
  return campaigns::draw(*std::ranges::find(kinds, kind, &campaigns::RecordKind::name), 1);
}

std::vector<Trial> trials_of(const campaigns::DrawnRecords& drawn) {
  std::vector<Trial> trials;
  for (const auto& record : drawn.records) {
    Trial trial;
    trial.number = static_cast<std::uint32_t>(trials.size() + 1);
    trial.sample_period = record.sample_period;
    trial.displacement = record.displacement;
    trial.force = record.force;
    trial.is_continuous = true;
    trials.push_back(trial);
  }
  return trials;
}

bool has(const Estimate& estimate, Reason reason) {
  return std::ranges::find(estimate.reasons, reason) != estimate.reasons.end();
}

TEST(ContinuousRecord, IsIdentifiedInTheFrequencyDomainUnlessAnotherMethodIsAskedFor) {
  const auto truth = drawn("resonance_0.11");
  const auto trials = trials_of(truth);
  const Estimate e = identify(trials, Options{}).value();
  EXPECT_EQ(e.method, Method::kSpectral);
  EXPECT_EQ(e.status, Status::kOk);
  EXPECT_TRUE(e.reasons.empty());
  EXPECT_NEAR(e.value.M(0, 0) / truth.M(0, 0), 1.0, 0.02);
  EXPECT_GT(e.band_high, e.band_low);
  EXPECT_GT(e.units, 5U);
  EXPECT_EQ(e.checks.size(), 14U);
  EXPECT_LE(e.force_lag_low[0], 0.0);
  EXPECT_GE(e.force_lag_high[0], 0.0);
  Options options;
  options.record_method = Method::kStateVariable;
  EXPECT_EQ(identify(trials, options).value().method, Method::kStateVariable);
}

TEST(ContinuousRecord, ByAPublishedMethodIsRightWithinItsIntervalOrRefused) {
  for (const char* kind : {"resonance_0.11", "resonance_0.01", "two_axes"}) {
    const auto truth = drawn(kind);
    const auto trials = trials_of(truth);
    for (const Method method : kMethods) {
      Options options;
      options.record_method = method;
      const Estimate e = identify(trials, options).value();
      ASSERT_NE(e.status, Status::kUndetermined) << kind << " " << name_of(method);
      EXPECT_EQ(e.uncertainty.M.known_bias.rows(), e.axes);
      if (e.status != Status::kOk) continue;
      const AxisMatrix margin = 0.5 * (e.high.M - e.low.M);
      EXPECT_TRUE((e.low.M - margin).cwiseMax(truth.M) == truth.M) << kind << " " << name_of(method);
      EXPECT_TRUE((e.high.M + margin).cwiseMin(truth.M) == truth.M) << kind << " " << name_of(method);
    }
  }
}

TEST(ContinuousRecord, ByAPublishedMethodIsHeldAgainstTheSpectralOne) {
  const auto trials = trials_of(drawn("friction"));
  for (const Method method : kMethods) {
    Options options;
    options.record_method = method;
    const Estimate e = identify(trials, options).value();
    EXPECT_EQ(e.status, Status::kSuspect) << name_of(method);
    ASSERT_TRUE(has(e, Reason::kFriction)) << name_of(method);
    EXPECT_TRUE(e.details.at(Reason::kFriction).starts_with("method spectral: "));
  }
}

TEST(ContinuousRecord, OfAForceWithTheOppositeSignSaysSoAndNamesTheOption) {
  auto trials = trials_of(drawn("resonance_0.05"));
  trials[0].force *= -1.0;
  const Estimate e = identify(trials, Options{}).value();
  EXPECT_EQ(e.status, Status::kSuspect);
  ASSERT_TRUE(has(e, Reason::kForceSign));
  EXPECT_NE(e.details.at(Reason::kForceSign).find("--force-sign"), std::string::npos);
  EXPECT_FALSE(has(e, Reason::kNegativeStiffness));
  Options options;
  options.model = Model::kFriction;
  const Estimate with_friction = identify(trials, options).value();
  EXPECT_TRUE(has(with_friction, Reason::kForceSign));
  EXPECT_FALSE(has(with_friction, Reason::kNegativeMass));
}

TEST(ContinuousRecord, StatesTheFailedTestWithItsNumberAndLimit) {
  const Estimate e = identify(trials_of(drawn("friction")), Options{}).value();
  EXPECT_EQ(e.status, Status::kSuspect);
  ASSERT_TRUE(has(e, Reason::kFriction));
  EXPECT_NE(e.details.at(Reason::kFriction).find("at most"), std::string::npos);
}

TEST(ContinuousRecord, HandleMassIsTakenFromTheMass) {
  const auto truth = drawn("two_axes");
  auto trials = trials_of(truth);
  const Estimate without = identify(trials, Options{}).value();
  trials[0].handle_mass = 0.1 * truth.M(0, 0);
  const Estimate with = identify(trials, Options{}).value();
  EXPECT_NEAR(with.value.M(0, 0), without.value.M(0, 0) - trials[0].handle_mass, 1e-12 * truth.M(0, 0));
  EXPECT_EQ(with.value.M(0, 1), without.value.M(0, 1));
}

TEST(ContinuousRecord, WithMissingRowsIsRefusedByThePublishedMethodsAndUsedByTheSpectralOne) {
  auto trials = trials_of(drawn("resonance_0.05"));
  trials[0].is_missing.assign(static_cast<std::size_t>(trials[0].samples()), false);
  trials[0].is_missing[500] = true;
  EXPECT_EQ(identify(trials, Options{}).value().status, Status::kOk);
  Options options;
  options.record_method = Method::kLowpass;
  const auto refused = identify(trials, options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("1 missing rows are not allowed"), std::string::npos);
}

TEST(ContinuousRecord, IsNotMixedWithPerturbations) {
  auto trials = trials_of(drawn("events"));
  trials[1].is_continuous = false;
  trials[1].onset = 10;
  EXPECT_FALSE(identify(trials, Options{}));
  trials[0].is_continuous = false;
  Options options;
  options.method = Method::kSpectral;
  EXPECT_FALSE(identify({trials.data(), 1}, options)) << "perturbations have no spectral estimate";
}

TEST(PreparedRecord, MarksMissingRowsAndTakesTheMeanOfTheOthers) {
  std::vector<EndpointSample> samples(10);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].acquisition_ns = static_cast<std::int64_t>(i) * 1'000'000;
    samples[i].p_SE[0] = static_cast<double>(i);
    samples[i].f_S[0] = 2.0;
  }
  samples[4].p_SE[0] = std::nan("");
  samples[4].acquisition_ns = 0;
  Preparation preparation;
  preparation.axes = 1;
  preparation.sample_period = 0.001;
  std::vector<bool> is_missing(10);
  is_missing[4] = true;
  EXPECT_FALSE(prepare_record(1, samples, preparation)) << "a value that is not finite, and not marked";
  const Trial trial = prepare_record(1, samples, preparation, {}, is_missing).value();
  EXPECT_DOUBLE_EQ(trial.displacement(0, 0), -41.0 / 9.0);
  EXPECT_EQ(trial.displacement(4, 0), 0.0);
  EXPECT_EQ(trial.is_missing, is_missing);
}

}  // namespace
}  // namespace tonus::impedance::test
