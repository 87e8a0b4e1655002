#include "analysis_service/identification/identification_core.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <random>

#include "tests/support/made_up_trial/made_up_trial.hpp"

namespace tonus::identification {
namespace {

using std::chrono::milliseconds;
using testing::blocks_of;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::made_up_condition;
using testing::made_up_trial;
using ::testing::Not;
using ::testing::SizeIs;

Clock::TimePoint at(int ms) { return Clock::TimePoint(milliseconds(ms)); }

CoreSettings fixed_frequency() {
  CoreSettings settings;
  settings.live.natural_frequency = 2.5;
  settings.live.has_trace = false;
  settings.book.analyses = {settings.live};
  return settings;
}

class IdentificationCoreTest : public ::testing::Test {
 protected:
  static void introduce(IdentificationCore& core) {
    core.set_rig(testing::made_up_rig_id(), testing::made_up_rig(), testing::kRate);
    core.set_session(testing::made_up_session());
  }
  static void add(IdentificationCore& core, const MeasuredTrial& trial) {
    for (const auto& block : blocks_of(trial, 100)) core.add(block);
  }
  /// Calls advance, and live as the service does, until there is nothing to do at `now`.
  IdentificationCore::Output advance(IdentificationCore& core, Clock::TimePoint now) {
    IdentificationCore::Output all;
    do {
      auto output = core.advance(now, true);
      std::move(output.verdicts.begin(), output.verdicts.end(), std::back_inserter(all.verdicts));
      std::move(output.estimates.begin(), output.estimates.end(), std::back_inserter(all.estimates));
      std::move(output.requests.begin(), output.requests.end(), std::back_inserter(all.requests));
      std::move(output.remarks.begin(), output.remarks.end(), std::back_inserter(all.remarks));
      now_live_ = core.live(now);
    } while (core.next_due(now) <= now);
    return all;
  }

  std::optional<ConditionEstimate> now_live_;
  IdentificationCore core_{fixed_frequency()};
  std::vector<MeasuredTrial> trials_ = made_up_condition();
};

TEST_F(IdentificationCoreTest, GivesTheVerdictFirstAndTheEstimateInALaterCall) {
  introduce(core_);
  add(core_, trials_[0]);
  core_.add(trials_[0].report, at(0));
  const auto first = core_.advance(at(0), true);
  ASSERT_THAT(first.verdicts, SizeIs(1));
  EXPECT_TRUE(first.verdicts[0].verdict.is_valid) << first.verdicts[0].verdict.detail;
  EXPECT_THAT(first.estimates, IsEmpty());
  EXPECT_EQ(core_.next_due(at(0)), at(0));
  EXPECT_THAT(core_.advance(at(0), true).estimates, SizeIs(1));
}

TEST_F(IdentificationCoreTest, GivesTheSameEstimateAfterARestartFromReportsAndResentRows) {
  introduce(core_);
  std::vector<ConditionEstimate> live_path;
  for (const auto& trial : trials_) {
    core_.expect(trial.report.plan);
    add(core_, trial);
    core_.add(trial.report, at(0));
    live_path = advance(core_, at(0)).estimates;
  }
  ASSERT_THAT(live_path, SizeIs(1));

  IdentificationCore restarted(fixed_frequency());
  introduce(restarted);
  for (const auto& trial : trials_) restarted.add(trial.report, at(0));
  std::vector<ConditionEstimate> estimates;
  std::size_t verdicts = 0;
  for (int ms = 0; ms < 10'000 && verdicts < trials_.size(); ms += 10) {
    const auto output = advance(restarted, at(ms));
    verdicts += output.verdicts.size();
    estimates.insert(estimates.end(), output.estimates.begin(), output.estimates.end());
    for (const auto& request : output.requests) {
      const auto wanted = std::find_if(trials_.begin(), trials_.end(), [&](const MeasuredTrial& trial) {
        return trial.report.range == request.range;
      });
      ASSERT_NE(wanted, trials_.end());
      add(restarted, *wanted);
    }
  }
  EXPECT_EQ(verdicts, trials_.size());
  ASSERT_THAT(estimates, SizeIs(1));  // none from a part of the trials
  EXPECT_EQ(estimates[0].estimate.trials_used, live_path[0].estimate.trials_used);
  EXPECT_EQ(estimates[0].estimate.value.M, live_path[0].estimate.value.M);
  EXPECT_EQ(estimates[0].estimate.value.K, live_path[0].estimate.value.K);
  EXPECT_EQ(estimates[0].estimate.high.B, live_path[0].estimate.high.B);
}

TEST_F(IdentificationCoreTest, RevisesTheEstimateAtOnceWhenATrialIsRejectedByHand) {
  introduce(core_);
  IdentificationCore without(fixed_frequency());
  introduce(without);
  std::vector<ConditionEstimate> expected;
  for (const auto& trial : trials_) {
    add(core_, trial);
    core_.add(trial.report, at(0));
    (void)advance(core_, at(0));
    if (trial.report.plan.attempt == 5) continue;
    add(without, trial);
    without.add(trial.report, at(0));
    expected = advance(without, at(0)).estimates;
  }
  core_.reject(trials_[4].report.plan.trial, 5);
  EXPECT_EQ(core_.next_due(at(0)), at(0));
  const auto revised = advance(core_, at(0));
  EXPECT_THAT(revised.verdicts, IsEmpty());  // what was measured stays as it is
  ASSERT_THAT(revised.estimates, SizeIs(1));
  EXPECT_EQ(revised.estimates[0].estimate.trials_used, expected.at(0).estimate.trials_used);
  EXPECT_EQ(revised.estimates[0].estimate.value.K, expected.at(0).estimate.value.K);
  EXPECT_EQ(revised.estimates[0].estimate.low.M, expected.at(0).estimate.low.M);
  core_.reject(trials_[4].report.plan.trial, 5);  // published anew by a restarted scheduler
  EXPECT_THAT(advance(core_, at(0)).estimates, IsEmpty());
}

TEST_F(IdentificationCoreTest, LeavesATrialOutWhoseRejectionCameBeforeItsRows) {
  introduce(core_);
  core_.reject(trials_[4].report.plan.trial, 5);
  std::vector<ConditionEstimate> estimates;
  for (const auto& trial : trials_) {
    add(core_, trial);
    core_.add(trial.report, at(0));
    const auto output = advance(core_, at(0));
    ASSERT_THAT(output.verdicts, SizeIs(1));
    EXPECT_TRUE(output.verdicts[0].verdict.is_valid);
    estimates = output.estimates;
  }
  ASSERT_THAT(estimates, SizeIs(1));
  EXPECT_THAT(estimates[0].estimate.trials_used, SizeIs(15));
  EXPECT_EQ(estimates[0].invalid_trials, 1U);
}

TEST_F(IdentificationCoreTest, IgnoresTheRejectionOfATrialOfAnotherSession) {
  introduce(core_);
  add(core_, trials_[0]);
  core_.add(trials_[0].report, at(0));
  (void)advance(core_, at(0));
  core_.reject(trial_id(id_of("another session"), 1), 1);
  EXPECT_THAT(advance(core_, at(0)).estimates, IsEmpty());
}

TEST_F(IdentificationCoreTest, LeavesARejectedTrialOutOfTheLiveEstimateOfTheNext) {
  introduce(core_);
  IdentificationCore without(fixed_frequency());
  introduce(without);
  for (std::size_t i = 0; i < 8; ++i) {
    for (IdentificationCore* core : {&core_, &without}) {
      if (core == &without && i == 4) continue;
      add(*core, trials_[i]);
      core->add(trials_[i].report, at(0));
      (void)advance(*core, at(0));
    }
  }
  core_.reject(trials_[4].report.plan.trial, 5);
  (void)advance(core_, at(0));
  std::optional<ConditionEstimate> shown[2];
  int i = 0;
  for (IdentificationCore* core : {&core_, &without}) {
    core->expect(trials_[8].report.plan);
    add(*core, trials_[8]);
    shown[i++] = core->live(at(1000));
  }
  ASSERT_TRUE(shown[0] && shown[1]);
  EXPECT_EQ(shown[0]->estimate.trials_used, shown[1]->estimate.trials_used);
  EXPECT_EQ(shown[0]->estimate.value.K, shown[1]->estimate.value.K);
}

TEST_F(IdentificationCoreTest, ShowsTheConditionAtEachBlockWhileAPerturbationIsUnderWay) {
  introduce(core_);
  for (std::size_t i = 0; i < 15; ++i) {
    add(core_, trials_[i]);
    core_.add(trials_[i].report, at(0));
  }
  (void)advance(core_, at(0));
  const TrialReport& report = trials_[15].report;
  core_.expect(report.plan);
  std::vector<ConditionEstimate> live;
  int ms = 0;
  for (const auto& block : blocks_of(trials_[15], 2)) {  // as it comes in real time: 10 ms a block
    core_.add(block);
    auto estimate = core_.live(at(++ms));
    const std::uint64_t end = block.first_sequence + block.rows.size();
    ASSERT_EQ(estimate.has_value(), end > report.onset) << end;
    EXPECT_FALSE(core_.live(at(ms))) << "one a block";
    if (!estimate) continue;
    EXPECT_EQ(estimate->trials.back().range.end, end) << "of the newest row";
    live.push_back(std::move(*estimate));
  }
  core_.add(trials_[15].report, at(ms));
  const auto batch = advance(core_, at(ms)).estimates;
  ASSERT_THAT(batch, SizeIs(1));
  EXPECT_EQ(live.back().estimate.value.K, batch[0].estimate.value.K);
  EXPECT_EQ(live.back().estimate.value.M, batch[0].estimate.value.M);
}

TEST_F(IdentificationCoreTest, SpendsNoMoreThanATenthOfTheTimeOnLiveEstimates) {
  introduce(core_);
  core_.expect(trials_[0].report.plan);
  int ms = 1000;
  int estimates = 0;
  for (const auto& block : blocks_of(trials_[0], 2)) {
    core_.add(block);
    ms += 10;
    if (!core_.live(at(ms))) {
      if (estimates > 0) {
        EXPECT_GT(core_.next_due(at(ms)), at(ms)) << "nothing to do until it may";
      }
      continue;
    }
    core_.charge_live(std::chrono::milliseconds(5));  // half of a block's time
    ++estimates;
  }
  // 50 ms are saved up; from the onset on, 2.05 s with the way back give 205 ms more.
  EXPECT_GE(estimates, 45);
  EXPECT_LE(estimates, 52);
}

TEST_F(IdentificationCoreTest, LeavesAnInvalidTrialOutOfTheEstimate) {
  introduce(core_);
  testing::Recipe recipe;
  recipe.attempt = 17;
  recipe.amplitude = 0.02;
  recipe.first_sequence = 40'000;
  trials_.push_back(made_up_trial(recipe));
  for (const auto& trial : trials_) {
    add(core_, trial);
    core_.add(trial.report, at(0));
  }
  const auto output = advance(core_, at(0));
  ASSERT_THAT(output.verdicts, SizeIs(17));
  EXPECT_THAT(output.verdicts[16].verdict.defects, ElementsAre(Defect::kExcursion));
  ASSERT_THAT(output.estimates, SizeIs(1));
  EXPECT_THAT(output.estimates[0].estimate.trials_used, SizeIs(16));
  EXPECT_EQ(output.estimates[0].invalid_trials, 1U);
}

TEST_F(IdentificationCoreTest, WaitsForTheRigsDescriptionAndThenSaysThatItIsUnknown) {
  core_.set_session(testing::made_up_session());
  for (const std::size_t i : {0U, 1U}) {
    add(core_, trials_[i]);
    core_.add(trials_[i].report, at(0));
  }
  EXPECT_THAT(advance(core_, at(0)).verdicts, IsEmpty());
  EXPECT_EQ(core_.queue_depth(), 2U);
  EXPECT_EQ(core_.next_due(at(0)), at(5000));
  const auto unknown = advance(core_, at(5000)).verdicts;
  ASSERT_THAT(unknown, SizeIs(2));
  EXPECT_THAT(unknown[0].verdict.defects, ElementsAre(Defect::kUnknownRig));

  add(core_, trials_[2]);
  core_.add(trials_[2].report, at(5001));
  EXPECT_THAT(advance(core_, at(5001)).verdicts, IsEmpty());
  introduce(core_);
  const auto known = advance(core_, at(5002)).verdicts;
  ASSERT_THAT(known, SizeIs(1));
  EXPECT_TRUE(known[0].verdict.is_valid);
}

TEST_F(IdentificationCoreTest, DoesNotIdentifyAConditionWhoseTrialsWaitForRows) {
  introduce(core_);
  add(core_, trials_[0]);
  core_.add(trials_[0].report, at(0));
  core_.add(trials_[1].report, at(0));
  auto output = advance(core_, at(0));
  EXPECT_THAT(output.verdicts, SizeIs(1));
  EXPECT_THAT(output.estimates, IsEmpty());
  add(core_, trials_[1]);
  output = advance(core_, at(1));
  EXPECT_THAT(output.verdicts, SizeIs(1));
  EXPECT_THAT(output.estimates, SizeIs(1));
}

TEST_F(IdentificationCoreTest, GivesAnUnloadedSetItsOwnEstimateInALoadedSession) {
  introduce(core_);
  testing::Recipe recipe;
  recipe.attempt = 17;
  recipe.set = 3;
  recipe.bias = {0.8, 0.0};
  recipe.first_sequence = 40'000;
  trials_.push_back(made_up_trial(recipe));
  for (const auto& trial : trials_) {
    add(core_, trial);
    core_.add(trial.report, at(0));
  }
  std::vector<std::int32_t> sets;
  for (const auto& estimate : advance(core_, at(0)).estimates) sets.push_back(estimate.condition.set);
  EXPECT_THAT(sets, ::testing::UnorderedElementsAre(0, 1, 2, 3));
}

/// Noise on one EMG channel at 2 kHz, its deviation before the onset as given; the rest of the trial is
/// quiet.
std::vector<float> emg_of(const MeasuredTrial& trial, double before_onset) {
  std::vector<float> values;
  std::mt19937 generator(trial.report.plan.attempt);
  std::normal_distribution<double> noise;
  for (std::uint64_t number = trial.report.range.first; number < trial.report.range.end; ++number) {
    const double deviation = number < trial.report.onset ? before_onset : 0.01;
    for (int i = 0; i < 10; ++i) values.push_back(static_cast<float>(deviation * noise(generator)));
  }
  return values;
}

class MusclesInTheCore : public IdentificationCoreTest {
 protected:
  void SetUp() override {
    const std::vector<AuxiliaryChannel> channels{{"biceps", "EMG", "V", 1.0, 10.0 * testing::kRate}};
    core_.set_rig(testing::made_up_rig_id(), testing::made_up_rig(), testing::kRate, false, channels);
    core_.set_session(testing::made_up_session(), {0.1, {}});
    trials_[0].report.plan.kind = TrialKind::kContraction;
  }
  void add_emg(const MeasuredTrial& trial, double before_onset) {
    const auto values = emg_of(trial, before_onset);
    const auto rows = static_cast<std::uint32_t>(trial.report.range.count());
    core_.add(AuxiliaryRows{trial.report.plan.rig, trial.report.plan.trial, trial.report.epoch,
                            trial.report.range.first, rows, values});
  }
  Verdict judge(const MeasuredTrial& trial, double before_onset) {
    add_emg(trial, before_onset);
    add(core_, trial);
    core_.add(trial.report, at(now_));
    auto output = core_.advance(at(now_), true);
    EXPECT_THAT(output.verdicts, SizeIs(1));
    return output.verdicts.empty() ? Verdict() : output.verdicts[0].verdict;
  }

  int now_ = 0;
};

TEST_F(MusclesInTheCore, ASubjectWhoIsNotRelaxedIsRejectedInExactlyThoseTrials) {
  EXPECT_TRUE(judge(trials_[0], 1.0).is_valid) << "the reference contraction";
  for (std::size_t i = 1; i < trials_.size(); ++i) {
    const bool is_tense = i == 3 || i == 8;
    const Verdict verdict = judge(trials_[i], is_tense ? 0.3 : 0.04);
    EXPECT_EQ(verdict.is_valid, !is_tense) << "trial " << i << ": " << verdict.detail;
    if (is_tense) {
      EXPECT_THAT(verdict.defects, ElementsAre(Defect::kMusclesActive));
    }
    ASSERT_THAT(verdict.activity.muscles, SizeIs(1));
    EXPECT_TRUE(verdict.activity.muscles[0].is_normalised);
    EXPECT_NEAR(verdict.activity.muscles[0].before_onset, is_tense ? 0.3 : 0.04, is_tense ? 0.05 : 0.01);
  }
}

TEST_F(MusclesInTheCore, AContractionEntersNoEstimate) {
  judge(trials_[0], 1.0);
  EXPECT_THAT(advance(core_, at(0)).estimates, IsEmpty());
  judge(trials_[1], 0.01);
  const auto estimates = advance(core_, at(0)).estimates;
  ASSERT_THAT(estimates, Not(IsEmpty()));
  for (const auto& estimate : estimates) EXPECT_THAT(estimate.estimate.trials_used, SizeIs(::testing::Le(1)));
}

TEST_F(MusclesInTheCore, AContractionRejectedByHandIsNoReferenceOfTheTrialsAfterIt) {
  trials_[1].report.plan.kind = TrialKind::kContraction;
  judge(trials_[0], 1.0);
  judge(trials_[1], 0.25);
  const auto activity = [&](std::size_t trial) {
    const Verdict verdict = judge(trials_[trial], 0.02);
    EXPECT_TRUE(verdict.activity.muscles.at(0).is_normalised) << trial;
    return verdict.activity.muscles.at(0).before_onset;
  };
  EXPECT_NEAR(activity(2), 0.02, 0.004);
  core_.reject(trials_[0].report.plan.trial, trials_[0].report.plan.attempt);
  EXPECT_NEAR(activity(3), 0.08, 0.016) << "relative to the other contraction, a quarter as strong";
  core_.reject(trials_[1].report.plan.trial, trials_[1].report.plan.attempt);
  const Verdict without = judge(trials_[4], 0.3);
  EXPECT_FALSE(without.activity.muscles.at(0).is_normalised);
  EXPECT_TRUE(without.is_valid) << "nothing is said without a reference";
}

TEST_F(MusclesInTheCore, AContractionThatWasRejectedBeforeItsValuesCameAnewIsNoReference) {
  core_.reject(trials_[0].report.plan.trial, trials_[0].report.plan.attempt);
  EXPECT_TRUE(judge(trials_[0], 1.0).is_valid) << "the verdict is the judge's, the rejection the operator's";
  EXPECT_FALSE(judge(trials_[1], 0.3).activity.muscles.at(0).is_normalised);
}

TEST_F(MusclesInTheCore, AVerdictWaitsForTheValuesAndAsksForThem) {
  add(core_, trials_[1]);
  core_.add(trials_[1].report, at(0));
  EXPECT_THAT(core_.advance(at(0), true).verdicts, IsEmpty());
  const auto asking = core_.advance(at(300), true);
  EXPECT_THAT(asking.verdicts, IsEmpty());
  ASSERT_THAT(asking.requests, SizeIs(1));
  EXPECT_EQ(asking.requests[0].range, trials_[1].report.range);
  add_emg(trials_[1], 0.01);
  EXPECT_THAT(core_.advance(at(310), true).verdicts, SizeIs(1));
}

TEST_F(MusclesInTheCore, AVerdictIsGivenWithoutValuesThatNeverCome) {
  add(core_, trials_[1]);
  core_.add(trials_[1].report, at(0));
  EXPECT_THAT(core_.advance(at(0), true).verdicts, IsEmpty());
  const auto late = core_.advance(at(4000), true);
  ASSERT_THAT(late.verdicts, SizeIs(1));
  EXPECT_TRUE(late.verdicts[0].verdict.is_valid);
  EXPECT_TRUE(std::isnan(late.verdicts[0].verdict.activity.muscles.at(0).before_onset));
}

}  // namespace
}  // namespace tonus::identification
