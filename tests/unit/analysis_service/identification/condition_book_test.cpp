#include "analysis_service/identification/condition_book.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <random>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/identification/conversion.hpp"
#include "analysis_service/identification/live_estimator.hpp"
#include "tests/support/made_up_trial/made_up_trial.hpp"

namespace tonus::identification {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::made_up_condition;
using testing::made_up_trial;
using ::testing::SizeIs;

impedance::Trial converted(const MeasuredTrial& trial) {
  auto result = trial_from_rows(frame_of(trial.report), testing::made_up_rig(), trial.rows,
                                trial.report.onset - trial.report.range.first);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return std::move(result).value();
}

void add(ConditionBook& book, const MeasuredTrial& trial) {
  ASSERT_TRUE(book.add_valid(trial.report, converted(trial)));
}

std::string why(const impedance::Estimate& estimate) {
  std::string text{impedance::name_of(estimate.method)};
  for (const auto reason : estimate.reasons) {
    const auto detail = estimate.details.find(reason);
    text += fmt::format("; {}: {}", impedance::name_of(reason),
                        detail == estimate.details.end() ? "" : detail->second);
  }
  return text;
}

/// Same to the last bit.
void expect_same(const impedance::Estimate& a, const impedance::Estimate& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.trials_used, b.trials_used);
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_EQ(a.natural_frequency, b.natural_frequency);
  for (const auto part : {&impedance::Estimate::value, &impedance::Estimate::std, &impedance::Estimate::low,
                          &impedance::Estimate::high}) {
    EXPECT_EQ((a.*part).M, (b.*part).M);
    EXPECT_EQ((a.*part).B, (b.*part).B);
    EXPECT_EQ((a.*part).K, (b.*part).K);
    EXPECT_EQ((a.*part).X0, (b.*part).X0);
  }
}

TEST(ConditionBook, FindsTheArmThatTheTrialsWereMadeOf) {
  ConditionBook book;
  for (const auto& trial : made_up_condition()) add(book, trial);
  ASSERT_THAT(book.changed(), SizeIs(1));
  const auto estimates = book.identify(book.changed().front());
  ASSERT_THAT(estimates, SizeIs(1));
  const auto& found = estimates[0].estimate;
  EXPECT_EQ(found.status, impedance::Status::kOk) << estimates[0].refusal << why(found);
  const testing::TrueArm arm;
  EXPECT_LT((found.value.M - arm.M).cwiseAbs().maxCoeff(), 0.01 * arm.M.maxCoeff());
  EXPECT_LT((found.value.B - arm.B).cwiseAbs().maxCoeff(), 0.01 * arm.B.maxCoeff());
  EXPECT_LT((found.value.K - arm.K).cwiseAbs().maxCoeff(), 0.01 * arm.K.maxCoeff());
  EXPECT_THAT(estimates[0].trials, SizeIs(16));
  EXPECT_THAT(book.changed(), IsEmpty());
}

TEST(ConditionBook, GivesTheSameBitsInWhateverOrderTheTrialsCame) {
  auto trials = made_up_condition();
  ConditionBook in_order;
  for (const auto& trial : trials) add(in_order, trial);
  const auto condition = in_order.changed().front();
  const auto expected = in_order.identify(condition);
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::shuffle(trials.begin(), trials.end(), std::mt19937(seed));
    ConditionBook book;
    for (const auto& trial : trials) {
      add(book, trial);
      (void)book.identify(condition);  // intermediate estimates leave no trace
    }
    expect_same(book.identify(condition)[0].estimate, expected[0].estimate);
  }
}

TEST(ConditionBook, EqualsTheOffLineIdentificationOfTheSameTrials) {
  ConditionBook book;
  std::vector<impedance::Trial> trials;
  for (const auto& trial : made_up_condition()) {
    add(book, trial);
    trials.push_back(converted(trial));
  }
  const auto off_line = impedance::identify(trials, {});
  ASSERT_TRUE(off_line);
  expect_same(book.identify(book.changed().front())[0].estimate, *off_line);
}

TEST(ConditionBook, MakesWhatASessionNeedsBesideItsOwnAnalysesEachOnce) {
  ConditionBook book;  // state_variable
  impedance::Options refined;
  refined.method = impedance::Method::kRefined;
  book.set_further({impedance::Options{}, refined});
  for (const auto& trial : made_up_condition()) add(book, trial);
  const auto estimates = book.identify(book.changed().front());
  ASSERT_THAT(estimates, SizeIs(2));
  EXPECT_EQ(estimates[0].estimate.method, impedance::Method::kStateVariable);
  EXPECT_EQ(estimates[1].estimate.method, impedance::Method::kRefined);
}

TEST(ConditionBook, TakesAnAttemptOnce) {
  ConditionBook book;
  const auto trials = made_up_condition();
  for (const auto& trial : trials) add(book, trial);
  add(book, trials[3]);
  EXPECT_THAT(book.sources(book.changed().front()), SizeIs(16));
}

TEST(ConditionBook, CountsInvalidTrialsOfTheCondition) {
  ConditionBook book;
  const auto trials = made_up_condition();
  for (std::size_t i = 0; i < 12; ++i) add(book, trials[i]);
  book.add_invalid(trials[12].report);
  book.add_invalid(trials[12].report);
  book.add_invalid(trials[13].report);
  EXPECT_EQ(book.identify(book.changed().front())[0].invalid_trials, 2U);
}

TEST(ConditionBook, WithoutAWithdrawnTrialHasTheBitsOfNeverHavingHadIt) {
  const auto trials = made_up_condition();
  ConditionBook book;
  ConditionBook without;
  for (const auto& trial : trials) {
    add(book, trial);
    if (trial.report.plan.attempt != 5) add(without, trial);
  }
  const Condition condition = book.changed().front();
  (void)book.identify(condition);
  ASSERT_THAT(book.changed(), IsEmpty());
  book.withdraw(testing::made_up_session(), 5);
  ASSERT_THAT(book.changed(), SizeIs(1));
  const auto found = book.identify(condition);
  expect_same(found.at(0).estimate, without.identify(condition).at(0).estimate);
  EXPECT_EQ(found.at(0).invalid_trials, 1U);
  book.withdraw(testing::made_up_session(), 5);  // once is enough
  book.withdraw(id_of("another session"), 6);
  EXPECT_THAT(book.changed(), IsEmpty());
}

TEST(ConditionBook, TellsThatNothingIsLeftOfAConditionWhoseTrialsAreAllWithdrawn) {
  const auto trials = made_up_condition();
  ConditionBook book;
  add(book, trials[0]);
  const Condition condition = book.changed().front();
  const auto before = book.identify(condition);
  book.withdraw(testing::made_up_session(), trials[0].report.plan.attempt);
  const auto after = book.identify(condition);
  ASSERT_THAT(after, SizeIs(before.size()));
  EXPECT_EQ(after[0].estimate.method, before[0].estimate.method);
  EXPECT_EQ(after[0].estimate.status, impedance::Status::kUndetermined);
  EXPECT_THAT(after[0].trials, IsEmpty());
  EXPECT_EQ(after[0].invalid_trials, 1U);
}

TEST(ConditionBook, KeepsPosturesBiasesAndInstructionsApart) {
  ConditionBook book;
  testing::Recipe recipe;
  auto trial = made_up_trial(recipe);
  add(book, trial);
  recipe.attempt = 2;
  recipe.posture_index = 1;
  add(book, made_up_trial(recipe));
  recipe.attempt = 3;
  auto told = made_up_trial(recipe);
  told.report.plan.instruction = "stiffen along x";
  add(book, told);
  EXPECT_THAT(book.changed(), SizeIs(3));
}

TEST(ConditionBook, ShowsUnloadedSetsOneByOneOnceTheSessionIsLoaded) {
  ConditionBook book;
  for (const auto& trial : made_up_condition()) add(book, trial);  // sets 1 and 2 without bias
  ASSERT_THAT(book.changed(), SizeIs(1));
  EXPECT_EQ(book.changed().front().set, 0);
  (void)book.identify(book.changed().front());

  testing::Recipe recipe;
  recipe.attempt = 17;
  recipe.set = 3;
  recipe.bias = {0.8, 0.0};
  add(book, made_up_trial(recipe));
  std::vector<std::int32_t> sets;
  for (const auto& condition : book.changed()) sets.push_back(condition.set);
  EXPECT_THAT(sets, ElementsAre(1, 2, 3));
  for (const auto& condition : book.changed()) {
    EXPECT_THAT(book.sources(condition), SizeIs(condition.is_loaded() ? 1U : 8U));
  }
}

TEST(ConditionBook, HoldsABoundedNumberOfTrials) {
  BookSettings settings;
  settings.most_trials = 4;
  ConditionBook book(settings);
  const auto trials = made_up_condition();
  for (std::size_t i = 0; i < 4; ++i) add(book, trials[i]);
  const auto refused = book.add_valid(trials[4].report, converted(trials[4]));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
}

TEST(ConditionBook, FreesOtherSessions) {
  ConditionBook book;
  for (const auto& trial : made_up_condition()) add(book, trial);
  const auto condition = book.changed().front();
  book.keep_only(id_of("another session"));
  EXPECT_THAT(book.changed(), IsEmpty());
  EXPECT_THAT(book.identify(condition), IsEmpty());
}

TEST(ConditionBook, MakesEveryAnalysisThatItIsToldTo) {
  BookSettings settings;
  settings.analyses.clear();
  for (const auto method : impedance::kMethods) {
    impedance::Options options;
    options.method = method;
    settings.analyses.push_back(options);
  }
  ConditionBook book(settings);
  for (const auto& trial : made_up_condition()) add(book, trial);
  const auto condition = book.changed().front();
  std::set<Id> ids;
  for (const auto& estimate : book.identify(condition)) {
    EXPECT_EQ(estimate.estimate.status, impedance::Status::kOk) << why(estimate.estimate);
    ids.insert(estimate_id(condition, estimate.estimate.method, estimate.estimate.model));
  }
  EXPECT_THAT(ids, SizeIs(3));
}

TEST(LiveEstimator, EqualsTheBookAtTheEndWhetherTrialsWereFollowedOrNot) {
  impedance::Options options;
  options.natural_frequency = 2.5;
  options.has_trace = false;
  BookSettings settings;
  settings.analyses = {options};
  ConditionBook book(settings);
  LiveEstimator live(options);
  const auto rig = testing::made_up_rig();
  const auto trials = made_up_condition();
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const auto& trial = trials[i];
    const bool is_followed = i % 3 != 0;
    if (is_followed) {
      live.start(trial.report.plan, rig, testing::kRate, trial.report.epoch, trial.report.range.first);
      for (const auto& block : testing::blocks_of(trial, 17)) live.push(block.rows);
      EXPECT_EQ(live.next()->sequence, trial.report.range.end);
    }
    if (i + 1 < trials.size()) {
      ASSERT_TRUE(live.settle(trial, true, rig));
    }
    add(book, trial);
  }
  // The last one is not settled: the estimate stands on its rows as they came.
  ASSERT_EQ(15 % 3, 0);
  live.start(trials[15].report.plan, rig, testing::kRate, trials[15].report.epoch,
             trials[15].report.range.first);
  live.push(trials[15].rows);
  const auto streamed = live.estimate();
  ASSERT_TRUE(streamed);
  const auto batch = book.identify(book.changed().front());
  EXPECT_EQ(streamed->estimate.value.M, batch[0].estimate.value.M);
  EXPECT_EQ(streamed->estimate.value.B, batch[0].estimate.value.B);
  EXPECT_EQ(streamed->estimate.value.K, batch[0].estimate.value.K);
  EXPECT_EQ(streamed->estimate.std.K, batch[0].estimate.std.K);
  ASSERT_THAT(streamed->trials, SizeIs(16));
  EXPECT_EQ(streamed->trials[0].range, trials[0].report.range);
  EXPECT_EQ(streamed->trials[15].range, trials[15].report.range);  // the running one, up to its newest row
}

TEST(LiveEstimator, LeavesNoTraceOfATrialThatDoesNotCount) {
  impedance::Options options;
  options.natural_frequency = 2.5;
  const auto rig = testing::made_up_rig();
  const auto trials = made_up_condition();
  LiveEstimator with_spoilt(options);
  LiveEstimator without(options);
  for (std::size_t i = 0; i < 9; ++i) {
    if (i == 4) {
      testing::Recipe recipe;
      recipe.attempt = 99;
      recipe.added_force = [](double t, Phase) { return Eigen::Vector2d(3.0 * t, 0.0); };
      const auto spoilt = made_up_trial(recipe);
      with_spoilt.start(spoilt.report.plan, rig, testing::kRate, 7, spoilt.report.range.first);
      with_spoilt.push(spoilt.rows);
      ASSERT_TRUE(with_spoilt.settle(spoilt, false, rig));
      EXPECT_FALSE(with_spoilt.next());
    }
    if (i == 8) break;
    ASSERT_TRUE(with_spoilt.settle(trials[i], true, rig));
    ASSERT_TRUE(without.settle(trials[i], true, rig));
  }
  for (auto* live : {&with_spoilt, &without}) {
    live->start(trials[8].report.plan, rig, testing::kRate, 7, trials[8].report.range.first);
    live->push(trials[8].rows);
  }
  ASSERT_TRUE(with_spoilt.estimate());
  EXPECT_EQ(with_spoilt.estimate()->estimate.value.K, without.estimate()->estimate.value.K);
}

TEST(LiveEstimator, AddsATrialWholeWhoseBeginningItMissed) {
  impedance::Options options;
  options.natural_frequency = 2.5;
  const auto rig = testing::made_up_rig();
  const auto trials = made_up_condition();
  LiveEstimator late(options);
  LiveEstimator whole(options);
  for (std::size_t i = 0; i < 8; ++i) {
    const auto& trial = trials[i];
    late.start(trial.report.plan, rig, testing::kRate, 7, trial.report.onset - 10);
    late.push(std::span(trial.rows).subspan(trial.report.onset - 10 - trial.report.range.first, 100));
    ASSERT_TRUE(late.settle(trial, true, rig));
    ASSERT_TRUE(whole.settle(trial, true, rig));
  }
  for (auto* live : {&late, &whole}) {
    live->start(trials[8].report.plan, rig, testing::kRate, 7, trials[8].report.range.first);
    live->push(trials[8].rows);
  }
  EXPECT_EQ(late.estimate()->estimate.value.K, whole.estimate()->estimate.value.K);
}

}  // namespace
}  // namespace tonus::identification
