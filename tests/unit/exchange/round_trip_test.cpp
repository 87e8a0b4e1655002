#include <gtest/gtest.h>

#include "services/archive/memory_store.hpp"
#include "services/exchange/estimate_difference.hpp"
#include "services/exchange/session_import.hpp"
#include "services/exchange/session_recordings.hpp"
#include "services/exchange/verification.hpp"
#include "services/recording/dataset.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/exchange/made_up_session.hpp"
#include "tests/unit/identification/made_up_trial.hpp"

namespace tonus::exchange {
namespace {

class RoundTrip : public ::testing::Test {
 protected:
  archive::Session archived(testing::SessionRecipe recipe) {
    const auto record = testing::put_session(original_, std::move(recipe));
    auto session = archive::read_session(original_, record.session);
    EXPECT_TRUE(session) << session.error().message;
    return *session;
  }

  /// Out to files and in again, into another archive.
  archive::Session there_and_back(const archive::Session& session) {
    const auto recordings = recordings_of(original_, session);
    EXPECT_TRUE(recordings) << recordings.error().message;
    const auto written = recording::write_dataset(folder_ / "dataset", *recordings);
    EXPECT_TRUE(written) << written.error().message;
    const auto read = recording::read_dataset(folder_ / "dataset");
    EXPECT_TRUE(read) << read.error().message;
    const auto imported = import_recordings(copy_, *read, {"dataset", "0.1.0", 99});
    EXPECT_TRUE(imported) << imported.error().message;
    EXPECT_EQ(imported->size(), 1U);
    auto again = archive::read_session(copy_, imported->at(0).session);
    EXPECT_TRUE(again) << again.error().message;
    return *again;
  }

  static void expect_same_numbers(const archive::Session& a, const archive::Session& b) {
    const auto before = archive::newest_estimates(a);
    const auto after = archive::newest_estimates(b);
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
      const auto difference = difference_of(before[i], after[i]);
      EXPECT_TRUE(difference.is_equal)
          << condition_text(before[i]) << " differs in " << difference.where << " by " << difference.largest;
    }
  }

  ::tonus::testing::TemporaryFolder folder_;
  archive::MemoryStore original_;
  archive::MemoryStore copy_;
};

TEST_F(RoundTrip, ThroughBidsGivesTheSameEstimatesToTheLastBit) {
  const auto session = archived(testing::unloaded_session());
  const auto again = there_and_back(session);
  EXPECT_EQ(again.trials.size(), 16U);
  EXPECT_TRUE(again.is_whole());
  ASSERT_EQ(archive::newest_estimates(session).size(), 1U);
  expect_same_numbers(session, again);
}

TEST_F(RoundTrip, KeepsEverySampleWithItsPhase) {
  const auto session = archived(testing::unloaded_session());
  const auto again = there_and_back(session);
  ASSERT_EQ(again.trials.size(), session.trials.size());
  for (std::size_t i = 0; i < session.trials.size(); ++i) {
    const auto before = archive::read_trial_samples(original_, session.trials[i]);
    const auto after = archive::read_trial_samples(copy_, again.trials[i]);
    ASSERT_TRUE(before && after);
    ASSERT_EQ(before->size(), after->size());
    for (std::size_t row = 0; row < before->size(); ++row) {
      EXPECT_EQ((*before)[row].encoder_count(), (*after)[row].encoder_count());
      EXPECT_EQ((*before)[row].force_V(), (*after)[row].force_V());
      EXPECT_EQ((*before)[row].commanded_m(), (*after)[row].commanded_m());
      EXPECT_EQ((*before)[row].phase(), (*after)[row].phase());
    }
    const auto& was = session.trials[i].outcome->value;
    const auto& is = again.trials[i].outcome->value;
    EXPECT_EQ(was.onset_sequence() - was.first_sequence(), is.onset_sequence() - is.first_sequence());
    EXPECT_EQ(was.program().direction_deg(), is.program().direction_deg());
  }
}

TEST_F(RoundTrip, KeepsLoadedConditionsSetBySet) {
  auto recipe = testing::unloaded_session();
  for (std::uint32_t i = 0; i < 16; ++i) {
    identification::testing::Recipe loaded;
    loaded.attempt = 17 + i;
    loaded.direction_deg = 45.0 * (i % 8);
    loaded.set = 3;
    loaded.bias = {0.7, -0.2};
    loaded.first_sequence = 20'000 + 1000 * i;
    recipe.trials.push_back(identification::testing::made_up_trial(loaded));
  }
  const auto session = archived(std::move(recipe));
  // Unloaded sets together and one by one, and the loaded one.
  ASSERT_EQ(archive::newest_estimates(session).size(), 4U);
  expect_same_numbers(session, there_and_back(session));
}

TEST_F(RoundTrip, KeepsWhyATrialDoesNotCount) {
  auto recipe = testing::unloaded_session();
  recipe.rejected_attempt = 6;
  const auto session = archived(std::move(recipe));
  const auto again = there_and_back(session);
  ASSERT_TRUE(again.trials[5].verdict);
  EXPECT_FALSE(again.trials[5].verdict->value.is_valid());
  EXPECT_NE(again.trials[5].verdict->value.detail().find("broken off"), std::string::npos);
  expect_same_numbers(session, again);
}

TEST_F(RoundTrip, OfASessionWithLostSamplesMarksThemAsMissing) {
  auto recipe = testing::unloaded_session();
  recipe.is_block_lost = [](std::uint64_t first) { return first == 3700; };
  const auto session = archived(std::move(recipe));
  const auto recordings = recordings_of(original_, session);
  ASSERT_TRUE(recordings) << recordings.error().message;
  ASSERT_EQ(recordings->size(), 1U);
  const auto missing = std::count_if(recordings->front().rows.begin(), recordings->front().rows.end(),
                                     [](const auto& row) { return row.is_missing; });
  EXPECT_EQ(missing, 50);
}

TEST_F(RoundTrip, WhatWasImportedIsVerified) {
  const auto again = there_and_back(archived(testing::unloaded_session()));
  const auto v = verify_session(copy_, again.record);
  ASSERT_TRUE(v) << v.error().message;
  EXPECT_TRUE(v->is_well()) << v->problems.front();
  ASSERT_EQ(v->estimates.size(), 1U);
  EXPECT_EQ(v->estimates[0].outcome, EstimateCheck::Outcome::kEqual);
}

TEST_F(RoundTrip, TheSameDatasetIsNotImportedTwice) {
  (void)there_and_back(archived(testing::unloaded_session()));
  const auto read = recording::read_dataset(folder_ / "dataset");
  ASSERT_TRUE(read);
  const auto twice = import_recordings(copy_, *read, {"dataset", "0.1.0", 100});
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().code, ErrorCode::kAlreadyExists);
  EXPECT_EQ(copy_.sessions()->size(), 1U);
}

TEST_F(RoundTrip, ADatasetThatStatesNoTrialsGivesThePerturbationsWithTheRestBefore) {
  const auto session = archived(testing::unloaded_session());
  auto recordings = recordings_of(original_, session);
  ASSERT_TRUE(recordings);
  for (auto& record : *recordings) {
    record.phases.clear();
    for (auto& event : record.events) event.trial_onset_s = event.trial_duration_s = std::nullopt;
  }
  const auto imported = import_recordings(copy_, *recordings, {"dataset", "0.1.0", 99});
  ASSERT_TRUE(imported) << imported.error().message;
  const auto again = archive::read_session(copy_, imported->at(0).session);
  ASSERT_TRUE(again);
  const auto estimates = archive::newest_estimates(*again);
  ASSERT_EQ(estimates.size(), 1U);
  EXPECT_EQ(estimates[0].trials_used(), 16U);
  // The perturbation of 1.75 s with 1 s before it, its end included, at 200 Hz.
  EXPECT_EQ(again->trials[0].record->range().count(), 551U);
}

}  // namespace
}  // namespace tonus::exchange
