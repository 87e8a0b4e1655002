#include "analysis_service/identification/trial_assembler.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <random>

#include "tests/support/made_up_trial/made_up_trial.hpp"

namespace tonus::identification {
namespace {

using std::chrono::milliseconds;
using testing::blocks_of;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::made_up_trial;
using testing::same_rows;
using ::testing::SizeIs;

Clock::TimePoint at(int ms) { return Clock::TimePoint(milliseconds(ms)); }

MeasuredTrial trial_number(std::uint32_t attempt) {
  testing::Recipe recipe;
  recipe.attempt = attempt;
  recipe.first_sequence = 1000 * attempt;
  return made_up_trial(recipe);
}

class TrialAssemblerTest : public ::testing::Test {
 protected:
  TrialAssemblerTest() { assembler_.set_session(testing::made_up_session()); }

  void add_all(const MeasuredTrial& trial) {
    for (const auto& block : blocks_of(trial, 50)) assembler_.add(block);
  }
  void add_all_but(const MeasuredTrial& trial, std::initializer_list<std::size_t> left_out) {
    const auto blocks = blocks_of(trial, 50);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (std::find(left_out.begin(), left_out.end(), i) == left_out.end()) assembler_.add(blocks[i]);
    }
  }

  TrialAssembler assembler_;
  MeasuredTrial trial_ = trial_number(1);
};

TEST_F(TrialAssemblerTest, GivesACompleteTrialAtOnceWithItsRowsInOrder) {
  add_all(trial_);
  assembler_.add(trial_.report, at(0));
  const auto progress = assembler_.advance(at(0), true);
  ASSERT_THAT(progress.finished, SizeIs(1));
  EXPECT_TRUE(same_rows(progress.finished[0].rows, trial_.rows));
  EXPECT_EQ(progress.finished[0].missing_rows, 0U);
  EXPECT_THAT(progress.requests, IsEmpty());
}

TEST_F(TrialAssemblerTest, ToleratesDisorderAndRepeats) {
  auto blocks = blocks_of(trial_, 37);
  const auto again = blocks;
  blocks.insert(blocks.end(), again.begin(), again.end());
  std::shuffle(blocks.begin(), blocks.end(), std::mt19937(3));
  for (const auto& block : blocks) assembler_.add(block);
  assembler_.add(trial_.report, at(0));
  const auto progress = assembler_.advance(at(0), true);
  ASSERT_THAT(progress.finished, SizeIs(1));
  EXPECT_TRUE(same_rows(progress.finished[0].rows, trial_.rows));
  EXPECT_EQ(assembler_.counts().repeated, trial_.rows.size());
}

TEST_F(TrialAssemblerTest, FinishesWhenTheLastRowsComeAfterTheReport) {
  add_all_but(trial_, {3});
  assembler_.add(trial_.report, at(0));
  EXPECT_THAT(assembler_.advance(at(0), true).finished, IsEmpty());
  assembler_.add(blocks_of(trial_, 50)[3]);
  EXPECT_THAT(assembler_.advance(at(1), true).finished, SizeIs(1));
}

TEST_F(TrialAssemblerTest, AsksForExactlyTheMissingRangesAfterTheFirstWait) {
  add_all_but(trial_, {3, 4, 8});
  assembler_.add(trial_.report, at(0));
  EXPECT_THAT(assembler_.advance(at(49), true).requests, IsEmpty());
  EXPECT_EQ(assembler_.next_due(), at(50));
  const auto requests = assembler_.advance(at(50), true).requests;
  ASSERT_THAT(requests, SizeIs(2));
  EXPECT_EQ(requests[0].range, (SequenceRange{1150, 1250}));
  EXPECT_EQ(requests[1].range, (SequenceRange{1400, 1450}));
  EXPECT_EQ(requests[0].rig, trial_.report.plan.rig);
  EXPECT_EQ(requests[0].epoch, trial_.report.epoch);
}

TEST_F(TrialAssemblerTest, RepeatsRequestsWithGrowingPausesAndThenGivesUp) {
  add_all_but(trial_, {3});
  assembler_.add(trial_.report, at(0));
  std::vector<int> asked_at;
  std::vector<MeasuredTrial> finished;
  for (int ms = 0; ms < 20'000 && finished.empty(); ++ms) {
    auto progress = assembler_.advance(at(ms), true);
    if (!progress.requests.empty()) asked_at.push_back(ms);
    finished = std::move(progress.finished);
  }
  // 50 ms, then 100, 200, 400, 800, 1600 and twice 2000 ms: the defaults, doubled up to the longest.
  EXPECT_THAT(asked_at, ElementsAre(50, 150, 350, 750, 1550, 3150, 5150, 7150));
  ASSERT_THAT(finished, SizeIs(1));
  EXPECT_EQ(finished[0].missing_rows, 50U);
  EXPECT_EQ(finished[0].resend_requests, 8U);
  EXPECT_EQ(std::count_if(finished[0].rows.begin(), finished[0].rows.end(),
                          [](const Row& row) { return row.is_missing; }),
            50);
  EXPECT_TRUE(finished[0].rows[150].is_missing);
  EXPECT_FALSE(finished[0].rows[149].is_missing);
}

TEST_F(TrialAssemblerTest, DoesNotGiveUpWhileRowsKeepComing) {
  assembler_.add(trial_.report, at(0));
  const auto blocks = blocks_of(trial_, 5);
  std::size_t next = 0;
  int ms = 0;
  std::vector<MeasuredTrial> finished;
  for (; ms < 600'000 && finished.empty(); ms += 10) {
    auto progress = assembler_.advance(at(ms), true);
    if (ms % 1000 == 0 && next < blocks.size()) assembler_.add(blocks[next++]);  // slower than a retry
    finished = std::move(progress.finished);
  }
  ASSERT_THAT(finished, SizeIs(1));
  EXPECT_EQ(finished[0].missing_rows, 0U);
}

TEST_F(TrialAssemblerTest, NeitherAsksNorGivesUpWhileNobodyHears) {
  assembler_.add(trial_.report, at(0));
  for (int ms = 0; ms < 60'000; ms += 10) {
    const auto progress = assembler_.advance(at(ms), false);
    ASSERT_THAT(progress.requests, IsEmpty());
    ASSERT_THAT(progress.finished, IsEmpty());
  }
  EXPECT_THAT(assembler_.advance(at(61'000), true).requests, SizeIs(1));
}

TEST_F(TrialAssemblerTest, AfterARestartAsksForTheNewestFirstAndAFewAtATime) {
  for (const std::uint32_t attempt : {2U, 5U, 1U, 7U, 3U, 6U, 4U}) {
    assembler_.add(trial_number(attempt).report, at(0));
  }
  const auto requests = assembler_.advance(at(50), true).requests;
  std::vector<std::uint64_t> first;
  for (const auto& request : requests) first.push_back(request.range.first);
  EXPECT_THAT(first, ElementsAre(7000, 6000, 5000, 4000));

  add_all(trial_number(6));
  const auto progress = assembler_.advance(at(60), true);
  EXPECT_THAT(progress.finished, SizeIs(1));
  ASSERT_THAT(progress.requests, SizeIs(1));
  EXPECT_EQ(progress.requests[0].range.first, 3000U);
  EXPECT_THAT(assembler_.waiting(), SizeIs(6));
}

TEST_F(TrialAssemblerTest, AsksOnlyForTheCurrentSession) {
  assembler_.set_session(id_of("another session"));
  assembler_.add(trial_.report, at(0));
  EXPECT_THAT(assembler_.advance(at(1000), true).requests, IsEmpty());
  EXPECT_EQ(assembler_.next_due(), Clock::TimePoint::max());
  assembler_.set_session(testing::made_up_session());
  EXPECT_THAT(assembler_.advance(at(1001), true).requests, SizeIs(1));
}

TEST_F(TrialAssemblerTest, GivesATrialOnceHoweverOftenItIsReported) {
  add_all(trial_);
  assembler_.add(trial_.report, at(0));
  assembler_.add(trial_.report, at(0));
  EXPECT_THAT(assembler_.advance(at(0), true).finished, SizeIs(1));
  assembler_.add(trial_.report, at(1));
  add_all(trial_);
  EXPECT_THAT(assembler_.advance(at(100), true).finished, IsEmpty());
  EXPECT_EQ(assembler_.rows_held(), 0U);
}

TEST_F(TrialAssemblerTest, DoesNotAskForATrialThatTheRigDidNotComplete) {
  trial_.report.end = TrialEnd::kAborted;
  assembler_.add(trial_.report, at(0));
  EXPECT_THAT(assembler_.advance(at(49), true).finished, IsEmpty());
  const auto progress = assembler_.advance(at(50), true);
  EXPECT_THAT(progress.requests, IsEmpty());
  EXPECT_THAT(progress.finished, SizeIs(1));
}

TEST_F(TrialAssemblerTest, GivesARefusedTrialWithoutRows) {
  trial_.report.end = TrialEnd::kRefused;
  trial_.report.range = {0, 1};
  assembler_.add(trial_.report, at(0));
  const auto finished = assembler_.advance(at(0), true).finished;
  ASSERT_THAT(finished, SizeIs(1));
  EXPECT_THAT(finished[0].rows, IsEmpty());
}

TEST_F(TrialAssemblerTest, KeepsNoRowsOutsideTrialsAndNoneOfFinishedOnes) {
  RowBlock idle = blocks_of(trial_, 50)[0];
  idle.trial = kNoId;
  assembler_.add(idle);
  EXPECT_EQ(assembler_.rows_held(), 0U);
  EXPECT_EQ(assembler_.counts().outside, 50U);
  add_all(trial_);
  EXPECT_EQ(assembler_.rows_held(), trial_.rows.size());
  assembler_.add(trial_.report, at(0));
  (void)assembler_.advance(at(0), true);
  EXPECT_EQ(assembler_.rows_held(), 0U);
}

TEST_F(TrialAssemblerTest, TellsEpochsApart) {
  MeasuredTrial other = trial_;
  other.report.epoch = 8;
  add_all(other);
  assembler_.add(trial_.report, at(0));
  EXPECT_THAT(assembler_.advance(at(0), true).finished, IsEmpty());
}

TEST_F(TrialAssemblerTest, ShowsTheRowsOfARunningTrialUpToTheFirstGap) {
  add_all_but(trial_, {2});
  EXPECT_EQ(assembler_.rows_from(trial_.report.plan.rig, trial_.report.epoch, 1010).size(), 90U);
}

TEST(TrialAssembler, GivesUpTheOldestUnclaimedRowsForWantOfRoomAndAsksForThemLater) {
  const auto first = trial_number(1);
  const auto second = trial_number(2);
  AssemblerLimits limits;
  limits.rows = first.rows.size() + 100;
  TrialAssembler assembler(limits);
  assembler.set_session(testing::made_up_session());
  for (const auto& trial : {first, second}) {
    for (const auto& block : blocks_of(trial, 50)) {
      assembler.add(block);
      ASSERT_LE(assembler.rows_held(), limits.rows);
    }
  }
  EXPECT_EQ(assembler.counts().evicted, first.rows.size());
  assembler.add(second.report, at(0));
  assembler.add(first.report, at(0));
  EXPECT_THAT(assembler.advance(at(0), true).finished, SizeIs(1));
  const auto requests = assembler.advance(at(50), true).requests;
  ASSERT_THAT(requests, SizeIs(1));
  EXPECT_EQ(requests[0].range, first.report.range);
}

TEST(TrialAssembler, CountsRowsThatFindNoRoomAndReportsATrialThatIsTooLong) {
  const auto trial = trial_number(1);
  AssemblerLimits limits;
  limits.rows = 200;
  TrialAssembler assembler(limits);
  assembler.set_session(testing::made_up_session());
  for (const auto& block : blocks_of(trial, 50)) assembler.add(block);
  EXPECT_LE(assembler.rows_held(), 200U);
  EXPECT_GT(assembler.counts().refused, 0U);
  EXPECT_EQ(assembler.counts().refused + assembler.counts().evicted + assembler.rows_held(),
            trial.rows.size());
  assembler.add(trial.report, at(0));
  const auto finished = assembler.advance(at(0), true).finished;
  ASSERT_THAT(finished, SizeIs(1));
  EXPECT_THAT(finished[0].rows, IsEmpty());
}

TEST(TrialAssembler, HoldsABoundedNumberOfReports) {
  AssemblerLimits limits;
  limits.trials_waiting = 3;
  TrialAssembler assembler(limits);
  assembler.set_session(testing::made_up_session());
  auto foreign = trial_number(9).report;
  foreign.plan.session = id_of("another session");
  assembler.add(foreign, at(0));
  for (std::uint32_t attempt = 1; attempt <= 5; ++attempt) assembler.add(trial_number(attempt).report, at(1));
  EXPECT_THAT(assembler.waiting(), SizeIs(3));
  EXPECT_EQ(assembler.counts().reports_dropped, 3U);  // the foreign one first, then those that found no place
}

// A link that loses, repeats and reorders blocks, and a rig that serves every request over the same link: all
// rows come out, each trial once. Seeds fixed.
TEST(TrialAssembler, RecoversEveryRowOverALinkThatLosesAThirdOfTheBlocks) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
    std::mt19937 random(seed);
    std::bernoulli_distribution is_lost(0.33);
    std::vector<MeasuredTrial> trials;
    for (std::uint32_t attempt = 1; attempt <= 6; ++attempt) trials.push_back(trial_number(attempt));
    TrialAssembler assembler;
    assembler.set_session(testing::made_up_session());
    std::vector<RowBlock> link;
    for (const auto& trial : trials) {
      for (const auto& block : blocks_of(trial, 20)) {
        link.push_back(block);
        if (random() % 4 == 0) link.push_back(block);
      }
    }
    std::vector<MeasuredTrial> finished;
    for (const auto& trial : trials) assembler.add(trial.report, at(0));
    for (int ms = 0; ms < 60'000 && finished.size() < trials.size(); ms += 10) {
      std::shuffle(link.begin(), link.end(), random);
      for (const auto& block : link) {
        if (!is_lost(random)) assembler.add(block);
      }
      link.clear();
      auto progress = assembler.advance(at(ms), true);
      std::move(progress.finished.begin(), progress.finished.end(), std::back_inserter(finished));
      for (const auto& request : progress.requests) {
        for (const auto& trial : trials) {
          for (const auto& block : blocks_of(trial, 20)) {
            const std::uint64_t last = block.first_sequence + block.rows.size() - 1;
            if (block.first_sequence < request.range.end && last >= request.range.first)
              link.push_back(block);
          }
        }
      }
    }
    ASSERT_THAT(finished, SizeIs(trials.size())) << "seed " << seed;
    for (const auto& trial : finished) {
      EXPECT_TRUE(same_rows(trial.rows, trials[trial.report.plan.attempt - 1].rows)) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace tonus::identification
