#include <algorithm>
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "services/store/archived_trial.hpp"
#include "services/store/open_store.hpp"
#include "services/store/session_reader.hpp"
#include "services/verification/verification.hpp"
#include "tests/integration/demo_run.hpp"

namespace tonus::testing {
namespace {

constexpr const char* kProtocol = R"(schema = 1
kind = "unloaded"
name = "muscles"
[[posture]]
name = "reference"
position_m = [0.0, 0.38]
[perturbation]
directions = 8
sets = 2
amplitude_m = 0.005
rise_time_s = 0.2
hold_s = [1.5, 2.0]
wait_s = [1.0, 1.5]
[limits]
muscle_activity = 0.08
[reference_contraction]
trials = 2
duration_s = 2.0
[[antagonists]]
first = "ElbowFlexor"
second = "ElbowExtensor"
)";

/// Trials of the subject are counted from 1, the two contractions with them.
constexpr const char* kMisconduct =
    "[subject.misconduct]\nis_on = true\ntenses_in_trials = [5, 11, 16]\nafter_s = 0.5\n";

std::string profile_text() {
  std::string text = kMisconduct;
  for (const char* name : {"ShoulderFlexor", "ShoulderExtensor", "ElbowFlexor", "ElbowExtensor",
                           "TwoJointFlexor", "TwoJointExtensor"})
    text += "[[auxiliary]]\nname = \"" + std::string(name) +
            "\"\ntype = \"EMG\"\nunit = \"mV\"\nrate_Hz = 2000.0\n";
  return text + "[[auxiliary]]\nname = \"Onset\"\ntype = \"TRIG\"\nunit = \"n/a\"\nrate_Hz = 200.0\n";
}

/// One session for all tests.
class MuscleSession : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryFolder folder;
    std::ofstream(folder / "muscles.toml") << kProtocol;
    std::ofstream(folder / "profile.toml") << profile_text();
    run_ = std::make_unique<DemoRun>(std::vector<std::string>{(folder / "muscles.toml").string(), "--profile",
                                                              (folder / "profile.toml").string(), "--seed",
                                                              "3", "--rig-seed", "3"});
    ASSERT_EQ(run_->finish(), 0) << run_->everything_printed();
    auto store = store::open_store_for_reading((run_->folder() / "data" / "archive.sqlite").string());
    ASSERT_TRUE(store) << store.error().message;
    store_ = std::move(*store);
    session_ = run_->archived();
    ASSERT_FALSE(session_.trials.empty());
  }
  static void TearDownTestSuite() {
    store_.reset();
    run_.reset();
  }

  static bool is_contraction(const store::SessionTrial& trial) {
    return trial.outcome->value.program().kind() == v1::TRIAL_CONTRACTION;
  }

  static std::unique_ptr<DemoRun> run_;
  static std::unique_ptr<store::Store> store_;
  static store::Session session_;
};

std::unique_ptr<DemoRun> MuscleSession::run_;
std::unique_ptr<store::Store> MuscleSession::store_;
store::Session MuscleSession::session_;

TEST_F(MuscleSession, BeginsWithTheReferenceContractionsAndRepeatsOnlyTheTrialsOfATenseSubject) {
  std::set<std::uint32_t> contractions;
  std::map<std::uint32_t, std::vector<v1::VerdictReason>> rejected;
  for (const auto& trial : session_.trials) {
    ASSERT_TRUE(trial.outcome && trial.verdict) << trial.attempt;
    if (is_contraction(trial)) contractions.insert(trial.attempt);
    if (!trial.verdict->value.is_valid()) rejected[trial.attempt] = trial.verdict->value.reasons();
  }
  EXPECT_EQ(contractions, (std::set<std::uint32_t>{1, 2}));
  const std::vector<v1::VerdictReason> active{v1::REASON_MUSCLES_ACTIVE};
  const std::map<std::uint32_t, std::vector<v1::VerdictReason>> expected{
      {5, active}, {11, active}, {16, active}};
  EXPECT_EQ(rejected, expected);
  EXPECT_EQ(session_.trials.size(), 2U + 16U + 3U);
  const auto estimates = store::newest_estimates(session_);
  ASSERT_FALSE(estimates.empty());
  for (const auto& estimate : estimates) {
    EXPECT_EQ(estimate.trials_used(), 16U) << estimate.method();
    EXPECT_EQ(estimate.trials_rejected(), 3U) << estimate.method();
  }
}

TEST_F(MuscleSession, HasTheActivityOfSixMusclesInEachVerdictRelativeToTheContraction) {
  for (const auto& trial : session_.trials) {
    if (is_contraction(trial)) continue;
    const v1::TrialVerdict& verdict = trial.verdict->value;
    ASSERT_EQ(verdict.muscles().size(), 6U) << trial.attempt;
    const double truth = verdict.is_valid() ? 0.02 : 0.17;  // the profile's rest, and tension beside it
    for (const v1::MuscleActivity& muscle : verdict.muscles()) {
      EXPECT_TRUE(muscle.is_normalised()) << muscle.channel();
      EXPECT_NEAR(muscle.before_onset(), truth, 0.25 * truth) << trial.attempt << " " << muscle.channel();
    }
    EXPECT_GT(verdict.co_contraction(), 0.8) << trial.attempt;
    EXPECT_LE(verdict.co_contraction(), 1.0) << trial.attempt;
  }
}

TEST_F(MuscleSession, LosesNoValueAndCertifiesSamplesWithTheirValues) {
  const auto streams = store_->streams();
  ASSERT_TRUE(streams);
  ASSERT_EQ(streams->size(), 1U);
  EXPECT_EQ(streams->front().auxiliary_values, 61U);  // 6 of 2 kHz and one of 200 Hz, at 200 Hz
  EXPECT_EQ(session_.certificate().missing, 0U);
  EXPECT_EQ(session_.certificate().received, session_.certificate().expected);
  for (const auto& trial : session_.trials) {
    const auto series = store::read_trial_auxiliary(*store_, trial, session_.descriptions.back().value);
    ASSERT_TRUE(series) << series.error().message;
    ASSERT_EQ(series->size(), 7U);
    EXPECT_EQ(series->front().values.size(), 10 * trial.record->range().count());
    for (const auto& one : *series) {
      const auto is_nan = [](float value) { return std::isnan(value); };
      // The rig's first sample ends with its first cycle: what precedes that was not measured.
      const auto begin = one.values.begin() + (trial.record->first_sequence == 0 ? one.values_per_sample : 0);
      EXPECT_EQ(std::count_if(begin, one.values.end(), is_nan), 0)
          << trial.attempt << " " << one.channel.name;
    }
  }
}

TEST_F(MuscleSession, NamesTheSampleInWhichTheOnsetWentHigh) {
  for (const auto& trial : session_.trials) {
    const v1::TrialOutcome& outcome = trial.outcome->value;
    ASSERT_TRUE(outcome.is_onset_marked()) << trial.attempt;
    const auto series = store::read_trial_auxiliary(*store_, trial, session_.descriptions.back().value);
    ASSERT_TRUE(series) << series.error().message;
    const auto& onset = series->back().values;
    const auto first = std::find(onset.begin(), onset.end(), 1.0F) - onset.begin();
    EXPECT_EQ(outcome.first_sequence() + static_cast<std::uint64_t>(first), outcome.mark_sequence())
        << trial.attempt;
    EXPECT_EQ(outcome.mark_sequence(), outcome.onset_sequence()) << trial.attempt;
  }
}

TEST_F(MuscleSession, IsVerifiedFromItsRawDataWithVerdictsAndEstimatesEqual) {
  const auto verified = verification::verify_session(*store_, session_.record, {});
  ASSERT_TRUE(verified) << verified.error().message;
  EXPECT_TRUE(verified->is_well()) << ::testing::PrintToString(verified->problems);
  for (const auto& check : verified->verdicts) EXPECT_TRUE(check.is_equal) << check.attempt;
}

TEST_F(MuscleSession, IsImportedFromItsDatasetWithItsContractionsAndTheSameActivityOfItsMuscles) {
  const TemporaryFolder folder;
  const auto dataset = (folder / "bids").string();
  const auto copy = (folder / "copy.sqlite").string();
  const auto archive = (run_->folder() / "data" / "archive.sqlite").string();
  for (const auto& words :
       {std::vector<std::string>{"export", "--format", "bids", "--out", dataset, "--archive", archive},
        {"import", dataset, "--archive", copy}}) {
    Process process(program("tonus"), words, folder / "output.log");
    ASSERT_EQ(process.wait(std::chrono::seconds(60)), 0) << process.output();
  }
  auto store = store::open_store_for_reading(copy);
  ASSERT_TRUE(store) << store.error().message;
  const auto records = store::list_sessions(**store);
  ASSERT_TRUE(records && records->size() == 1U);
  const auto imported = store::read_session(**store, records->front().session);
  ASSERT_TRUE(imported) << imported.error().message;
  ASSERT_EQ(imported->trials.size(), session_.trials.size());
  for (std::size_t i = 0; i < session_.trials.size(); ++i) {
    const auto& was = session_.trials[i];
    const auto& is = imported->trials[i];
    EXPECT_EQ(is.attempt, was.attempt);
    EXPECT_EQ(is_contraction(is), is_contraction(was)) << was.attempt;
    if (!was.verdict->value.is_valid()) continue;  // broken off, in the dataset
    const auto& had = was.verdict->value.muscles();
    const auto& has = is.verdict->value.muscles();
    ASSERT_EQ(has.size(), had.size()) << was.attempt;
    for (std::size_t muscle = 0; muscle < had.size(); ++muscle) {
      EXPECT_TRUE(has[muscle].is_normalised() || is_contraction(was)) << was.attempt;
      EXPECT_EQ(has[muscle].before_onset(), had[muscle].before_onset()) << was.attempt;
    }
  }
}

TEST_F(MuscleSession, IsReplayedFromItsExportedDatasetWithEveryValueAsItWas) {
  const TemporaryFolder folder;
  const auto dataset = (folder / "bids").string();
  Process exporting(program("tonus"),
                    {"export", "--format", "bids", "--out", dataset, "--archive",
                     (run_->folder() / "data" / "archive.sqlite").string()},
                    folder / "export.log");
  ASSERT_EQ(exporting.wait(std::chrono::seconds(60)), 0) << exporting.output();
  DemoRun replay({"--dataset", dataset});
  ASSERT_EQ(replay.finish(), 0) << replay.everything_printed();
  auto store = store::open_store_for_reading((replay.folder() / "data" / "archive.sqlite").string());
  ASSERT_TRUE(store) << store.error().message;
  const auto replayed = replay.archived();
  std::vector<const store::SessionTrial*> counted;
  for (const auto& trial : session_.trials) {
    if (!is_contraction(trial) && trial.verdict->value.is_valid()) counted.push_back(&trial);
  }
  ASSERT_EQ(replayed.trials.size(), counted.size());
  for (std::size_t i = 0; i < counted.size(); ++i) {
    const auto before = store::read_trial_auxiliary(*store_, *counted[i], session_.descriptions.back().value);
    const auto after =
        store::read_trial_auxiliary(**store, replayed.trials[i], replayed.descriptions.back().value);
    ASSERT_TRUE(before && after);
    ASSERT_EQ(after->size(), 7U);
    const v1::TrialOutcome& was = counted[i]->outcome->value;
    const v1::TrialOutcome& is = replayed.trials[i].outcome->value;
    const auto rest = is.onset_sequence() - is.first_sequence();
    for (std::size_t channel = 0; channel < after->size(); ++channel) {
      const auto& series = after->at(channel);
      const std::size_t begin =
          (was.onset_sequence() - was.first_sequence() - rest) * series.values_per_sample;
      EXPECT_EQ(series.channel.type, before->at(channel).channel.type);
      ASSERT_LE(begin + series.values.size(), before->at(channel).values.size());
      EXPECT_TRUE(std::equal(series.values.begin(), series.values.end(),
                             before->at(channel).values.begin() + static_cast<std::ptrdiff_t>(begin)))
          << series.channel.name << ", trial " << i;
    }
  }
}

}  // namespace
}  // namespace tonus::testing
