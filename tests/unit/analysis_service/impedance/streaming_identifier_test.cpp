#include "analysis_service/impedance/streaming_identifier.hpp"

#include <atomic>
#include <cstdlib>
#include <gtest/gtest.h>
#include <new>

#include "analysis_service/impedance/parameters.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

using tonus::testing::allocations;
using tonus::testing::counts_allocations;

struct Recorded {
  std::vector<EndpointSample> samples;
  std::size_t onset = 0;
};

std::vector<Recorded> record(int sets, std::uint64_t seed) {
  std::vector<Recorded> all;
  const SimulatedRig rig;
  for (const double direction : directions(sets)) {
    const RawTrial raw = simulate_raw(typical_subject(), rig, direction, ++seed);
    all.push_back({convert_all(rig, raw.samples), static_cast<std::size_t>(raw.onset)});
  }
  return all;
}

Preparation preparation(bool is_tared = true) {
  Preparation p;
  p.sample_period = 0.005;
  p.is_force_tared = is_tared;
  return p;
}

void feed(StreamingIdentifier& live, std::uint32_t number, const Recorded& trial) {
  live.begin_trial(number);
  for (std::size_t k = 0; k < trial.onset; ++k) live.push_rest(trial.samples[k]);
  live.mark_onset();
  for (std::size_t k = trial.onset; k < trial.samples.size(); ++k) live.push(trial.samples[k]);
  ASSERT_TRUE(live.end_trial());
}

void expect_same_bits(const Estimate& one, const Estimate& other) {
  EXPECT_EQ(flatten(one.value), flatten(other.value));
  EXPECT_EQ(flatten(one.std), flatten(other.std));
  EXPECT_EQ(flatten(one.low), flatten(other.low));
  EXPECT_EQ(flatten(one.high), flatten(other.high));
  EXPECT_EQ(one.sigma, other.sigma);
  EXPECT_EQ(one.condition_number, other.condition_number);
  EXPECT_EQ(one.natural_frequency, other.natural_frequency);
  EXPECT_EQ(one.samples, other.samples);
  EXPECT_EQ(one.trials_used, other.trials_used);
  EXPECT_EQ(one.status, other.status);
  EXPECT_EQ(one.reasons, other.reasons);
}

TEST(StreamingIdentifier, EndsWithTheBitsOfTheOfflineResult) {
  for (const bool is_tared : {true, false}) {
    for (const Model model : {Model::kLinear, Model::kNoDamping}) {
      Options options;
      options.model = model;
      auto live = StreamingIdentifier::create(options, preparation(is_tared)).value();
      const auto recorded = record(2, 100);
      std::vector<Trial> trials;
      for (std::size_t i = 0; i < recorded.size(); ++i) {
        const auto number = static_cast<std::uint32_t>(i + 1);
        feed(live, number, recorded[i]);
        trials.push_back(prepare_trial(number, recorded[i].samples,
                                       static_cast<Eigen::Index>(recorded[i].onset), preparation(is_tared))
                             .value());
      }
      const Estimate offline = identify(trials, options).value();
      // Without damping the model explains too little of the force, and says so.
      EXPECT_EQ(offline.status, model == Model::kLinear ? Status::kOk : Status::kSuspect);
      expect_same_bits(live.finish().value(), offline);
      expect_same_bits(live.estimate(), offline);
    }
  }
}

TEST(StreamingIdentifier, HasAtTheWindowsEndTheBitsItHasAtTheTrialsEnd) {
  // The path sample by sample and the one through the stored trial are the same numbers.
  Options options;
  options.natural_frequency = 2.6;
  auto live = StreamingIdentifier::create(options, preparation()).value();
  const auto recorded = record(1, 7);
  for (std::size_t i = 0; i + 1 < recorded.size(); ++i)
    feed(live, static_cast<std::uint32_t>(i + 1), recorded[i]);
  const Recorded& last = recorded.back();
  live.begin_trial(8);
  for (std::size_t k = 0; k < last.onset; ++k) live.push_rest(last.samples[k]);
  live.mark_onset();
  for (std::size_t k = last.onset; k < last.samples.size(); ++k) live.push(last.samples[k]);
  const Estimate before = live.estimate();
  ASSERT_TRUE(live.end_trial());
  const Estimate after = live.estimate();
  EXPECT_EQ(flatten(before.value), flatten(after.value));
  EXPECT_EQ(flatten(before.std), flatten(after.std));
  EXPECT_EQ(before.samples, 1600);
}

TEST(StreamingIdentifier, DoesNotDependOnTheOrderInWhichTrialsWereRun) {
  auto live = StreamingIdentifier::create(Options{}, preparation()).value();
  const auto recorded = record(1, 20);
  for (std::size_t i = recorded.size(); i-- > 0;) feed(live, static_cast<std::uint32_t>(i + 1), recorded[i]);
  auto forward = StreamingIdentifier::create(Options{}, preparation()).value();
  for (std::size_t i = 0; i < recorded.size(); ++i)
    feed(forward, static_cast<std::uint32_t>(i + 1), recorded[i]);
  expect_same_bits(live.estimate(), forward.estimate());
}

TEST(StreamingIdentifier, AllocatesNothingWhileSamplesArrive) {
  if (!counts_allocations()) GTEST_SKIP() << "a sanitizer's malloc cannot be counted";
  const std::size_t start = allocations();
  const auto on_the_heap =
      std::make_unique<Signals>(Signals::Zero(3, static_cast<Eigen::Index>(start % 2 + 1)));
  ASSERT_GE(allocations(), start + 2) << on_the_heap->sum() << ": the count misses what Eigen allocates";
  auto live = StreamingIdentifier::create(Options{}, preparation()).value();
  const auto recorded = record(1, 30);
  feed(live, 1, recorded[0]);
  const SimulatedRig rig;
  const RigGeometry geometry = geometry_of(rig);
  const ShoulderPose shoulder = shoulder_of(rig);
  const RawTrial raw = simulate_raw(typical_subject(), rig, 1.0, 3);
  const auto onset = static_cast<std::size_t>(raw.onset);
  live.begin_trial(2);
  const std::size_t before = allocations();
  for (std::size_t k = 0; k < onset; ++k) live.push_rest(convert(geometry, shoulder, raw.samples[k]));
  live.mark_onset();
  for (std::size_t k = onset; k < raw.samples.size(); ++k)
    live.push(convert(geometry, shoulder, raw.samples[k]));
  for (int k = 0; k < 2000; ++k) live.push(convert(geometry, shoulder, raw.samples.back()));
  EXPECT_EQ(allocations(), before);
}

TEST(StreamingIdentifier, IsUndeterminedUntilThePlaneIsExcited) {
  auto live = StreamingIdentifier::create(Options{}, preparation()).value();
  EXPECT_EQ(live.estimate().status, Status::kUndetermined);
  const auto recorded = record(1, 40);
  feed(live, 1, recorded[0]);
  feed(live, 2, recorded[4]);  // The opposite direction.
  EXPECT_EQ(live.estimate().status, Status::kUndetermined);
  EXPECT_EQ(live.estimate().reasons, std::vector{Reason::kSingleDirection});
  for (const std::size_t i : {1U, 2U, 3U, 5U}) feed(live, static_cast<std::uint32_t>(10 + i), recorded[i]);
  EXPECT_EQ(live.estimate().status, Status::kOk);
}

TEST(StreamingIdentifier, ForgetsADiscardedTrial) {
  auto live = StreamingIdentifier::create(Options{}, preparation()).value();
  const auto recorded = record(1, 50);
  for (std::size_t i = 0; i < 6; ++i) feed(live, static_cast<std::uint32_t>(i + 1), recorded[i]);
  const Estimate before = live.estimate();
  live.begin_trial(7);
  for (std::size_t k = 0; k < recorded[6].onset; ++k) live.push_rest(recorded[6].samples[k]);
  live.mark_onset();
  live.push(recorded[6].samples.back());
  live.discard_trial();
  expect_same_bits(live.estimate(), before);
  EXPECT_EQ(live.trials().size(), 6U);
}

TEST(StreamingIdentifier, WithoutARemovedTrialHasTheBitsOfNeverHavingHadIt) {
  auto live = StreamingIdentifier::create({}, preparation()).value();
  auto other = StreamingIdentifier::create({}, preparation()).value();
  const auto recorded = record(2, 100);
  for (std::uint32_t number = 1; number <= 8; ++number) {
    feed(live, number, recorded[number - 1]);
    if (number != 3) feed(other, number, recorded[number - 1]);
  }
  EXPECT_TRUE(live.remove_trial(3));
  expect_same_bits(live.estimate(), other.estimate());
  EXPECT_FALSE(live.remove_trial(3));
}

TEST(StreamingIdentifier, RemovesATrialWhileAnotherIsUnderWay) {
  auto live = StreamingIdentifier::create({}, preparation()).value();
  auto other = StreamingIdentifier::create({}, preparation()).value();
  const auto recorded = record(2, 100);
  const auto begin = [](StreamingIdentifier& to, const Recorded& trial, std::size_t end) {
    to.begin_trial(9);
    for (std::size_t k = 0; k < trial.onset; ++k) to.push_rest(trial.samples[k]);
    to.mark_onset();
    for (std::size_t k = trial.onset; k < end; ++k) to.push(trial.samples[k]);
  };
  for (std::uint32_t number = 1; number <= 8; ++number) {
    feed(live, number, recorded[number - 1]);
    if (number != 3) feed(other, number, recorded[number - 1]);
  }
  const std::size_t half = (recorded[8].onset + recorded[8].samples.size()) / 2;
  begin(live, recorded[8], half);
  begin(other, recorded[8], half);
  ASSERT_TRUE(live.remove_trial(3));
  expect_same_bits(live.estimate(), other.estimate());
  for (std::size_t k = half; k < recorded[8].samples.size(); ++k) {
    live.push(recorded[8].samples[k]);
    other.push(recorded[8].samples[k]);
  }
  ASSERT_TRUE(live.end_trial());
  ASSERT_TRUE(other.end_trial());
  expect_same_bits(live.estimate(), other.estimate());
}

TEST(StreamingIdentifier, WithoutAnyTrialLeftIsAsAtTheBegin) {
  auto live = StreamingIdentifier::create({}, preparation()).value();
  feed(live, 1, record(1, 100).front());
  ASSERT_TRUE(live.remove_trial(1));
  EXPECT_EQ(live.natural_frequency(), StreamingIdentifier::kProvisionalFrequency);
  EXPECT_TRUE(live.trials().empty());
  EXPECT_TRUE(live.estimate().trials_used.empty());
}

TEST(StreamingIdentifier, TunesItsFilterToTheTrialsSeen) {
  auto live = StreamingIdentifier::create(Options{}, preparation()).value();
  EXPECT_EQ(live.natural_frequency(), StreamingIdentifier::kProvisionalFrequency);
  feed(live, 1, record(1, 60)[0]);
  // The simulated step oscillates at 2.6 Hz: sqrt(2200 + K over 8 + M).
  EXPECT_NEAR(live.natural_frequency(), 2.6, 0.2);
}

TEST(StreamingIdentifier, CountsWhatItDoesNotKeep) {
  Options options;
  auto live = StreamingIdentifier::create(options, preparation(), 1.0).value();
  const auto recorded = record(1, 70);
  live.push(recorded[0].samples[0]);
  EXPECT_EQ(live.dropped(), 1U);
  feed(live, 1, recorded[0]);  // 1.5 s of motion, 1.0 s are kept.
  EXPECT_EQ(live.dropped(), 101U);
  EXPECT_EQ(live.trials()[0].samples(), 300);
}

TEST(StreamingIdentifier, RefusesWhatItCannotDoLive) {
  Options options;
  options.method = Method::kOptimal;
  EXPECT_EQ(StreamingIdentifier::create(options, preparation()).error().message,
            "streaming: method: optimal is not allowed; expected state_variable");
  options = {};
  options.model = Model::kCoriolis;
  EXPECT_FALSE(StreamingIdentifier::create(options, preparation()));
  EXPECT_FALSE(StreamingIdentifier::create(Options{}, preparation(), 0.5));
  EXPECT_FALSE(StreamingIdentifier::create(Options{}, Preparation{}));
}

TEST(StreamingIdentifier, RefusesANumberThatWasThereBefore) {
  auto live = StreamingIdentifier::create(Options{}, preparation()).value();
  const auto recorded = record(1, 80);
  feed(live, 1, recorded[0]);
  live.begin_trial(1);
  for (std::size_t k = 0; k < recorded[1].onset; ++k) live.push_rest(recorded[1].samples[k]);
  live.mark_onset();
  live.push(recorded[1].samples.back());
  const auto result = live.end_trial();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kAlreadyExists);
  EXPECT_EQ(live.trials().size(), 1U);
}

}  // namespace
}  // namespace tonus::impedance::test
