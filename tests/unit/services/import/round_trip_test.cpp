#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "services/formats/session_recordings.hpp"
#include "services/import/session_import.hpp"
#include "services/recording/dataset.hpp"
#include "services/store/archived_trial.hpp"
#include "services/store/memory_store.hpp"
#include "services/verification/estimate_difference.hpp"
#include "services/verification/verification.hpp"
#include "tests/support/made_up_session/made_up_session.hpp"
#include "tests/support/made_up_trial/made_up_trial.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::session_import {
namespace {

class RoundTrip : public ::testing::Test {
 protected:
  store::Session archived(made_up::SessionRecipe recipe) {
    const auto record = made_up::put_session(original_, std::move(recipe));
    auto session = store::read_session(original_, record.session);
    EXPECT_TRUE(session) << session.error().message;
    return *session;
  }

  /// Out to files and in again, into another archive.
  store::Session there_and_back(const store::Session& session) {
    const auto recordings = formats::recordings_of(original_, session);
    EXPECT_TRUE(recordings) << recordings.error().message;
    const auto written = recording::write_dataset(folder_ / "dataset", *recordings);
    EXPECT_TRUE(written) << written.error().message;
    const auto read = recording::read_dataset(folder_ / "dataset");
    EXPECT_TRUE(read) << read.error().message;
    const auto imported = import_recordings(copy_, *read, {"dataset", "0.1.0", 99});
    EXPECT_TRUE(imported) << imported.error().message;
    EXPECT_EQ(imported->size(), 1U);
    auto again = store::read_session(copy_, imported->at(0).session);
    EXPECT_TRUE(again) << again.error().message;
    return *again;
  }

  static void expect_same_numbers(const store::Session& a, const store::Session& b) {
    const auto before = store::newest_estimates(a);
    const auto after = store::newest_estimates(b);
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
      const auto difference = verification::difference_of(before[i], after[i]);
      EXPECT_TRUE(difference.is_equal) << verification::condition_text(before[i]) << " differs in "
                                       << difference.where << " by " << difference.largest;
    }
  }

  Result<std::vector<store::SessionRecord>> import_recordings(
      store::Store& store, const std::vector<recording::Recording>& recordings,
      const ImportSettings& settings) {
    const auto sessions = sessions_of(recordings, settings);
    if (!sessions) return sessions.error();
    return store_sessions(store, *sessions);
  }

  ::tonus::testing::TemporaryFolder folder_;
  store::MemoryStore original_;
  store::MemoryStore copy_;
};

TEST_F(RoundTrip, ThroughBidsGivesTheSameEstimatesToTheLastBit) {
  const auto session = archived(made_up::unloaded_session());
  const auto again = there_and_back(session);
  EXPECT_EQ(again.trials.size(), 16U);
  EXPECT_TRUE(again.is_whole());
  ASSERT_EQ(store::newest_estimates(session).size(), 1U);
  expect_same_numbers(session, again);
}

TEST_F(RoundTrip, KeepsEverySampleWithItsPhase) {
  const auto session = archived(made_up::unloaded_session());
  const auto again = there_and_back(session);
  ASSERT_EQ(again.trials.size(), session.trials.size());
  for (std::size_t i = 0; i < session.trials.size(); ++i) {
    const auto before = store::read_trial_samples(original_, session.trials[i]);
    const auto after = store::read_trial_samples(copy_, again.trials[i]);
    ASSERT_TRUE(before && after);
    ASSERT_EQ(before->samples.size(), after->samples.size());
    for (std::size_t row = 0; row < before->samples.size(); ++row) {
      const v1::RigSample& had = before->samples[row];
      const v1::RigSample& has = after->samples[row];
      EXPECT_EQ(had.encoder_count(), has.encoder_count());
      EXPECT_EQ(had.force_V(), has.force_V());
      EXPECT_EQ(had.commanded_m(), has.commanded_m());
      EXPECT_EQ(had.phase(), has.phase());
    }
    const auto& was = session.trials[i].outcome->value;
    const auto& is = again.trials[i].outcome->value;
    EXPECT_EQ(was.onset_sequence() - was.first_sequence(), is.onset_sequence() - is.first_sequence());
    EXPECT_EQ(was.program().direction_deg(), is.program().direction_deg());
  }
}

TEST_F(RoundTrip, KeepsEveryValueOfEveryAuxiliaryChannelAndWhichOnesAreNotThere) {
  auto recipe = made_up::unloaded_session();
  recipe.auxiliary = {{"Biceps", "EMG", "mV", 0.1, 2000.0},
                      {"Onset", "TRIG", "n/a", 1.0, 200.0},
                      {"Grip", "MISC", "N", -2.5, 400.0},
                      {"Triceps", "EMG", "mV", 0.3, 2000.0}};
  recipe.are_values_lost = [](std::uint64_t first) { return first == 3700; };
  const auto session = archived(std::move(recipe));
  const auto again = there_and_back(session);
  ASSERT_EQ(again.trials.size(), session.trials.size());
  std::size_t lost = 0;
  for (std::size_t i = 0; i < session.trials.size(); ++i) {
    const auto before =
        store::read_trial_auxiliary(original_, session.trials[i], session.descriptions.back().value);
    const auto after = store::read_trial_auxiliary(copy_, again.trials[i], again.descriptions.back().value);
    ASSERT_TRUE(before && after);
    ASSERT_EQ(before->size(), 4U);
    ASSERT_EQ(after->size(), 4U);
    for (std::size_t channel = 0; channel < before->size(); ++channel) {
      const AuxiliarySeries& had = before->at(channel);
      const AuxiliarySeries& has = after->at(channel);
      EXPECT_EQ(has.channel.name, had.channel.name);
      EXPECT_EQ(has.channel.type, had.channel.type);
      EXPECT_EQ(has.channel.unit, had.channel.unit);
      EXPECT_EQ(has.channel.rate, had.channel.rate);
      ASSERT_EQ(has.values.size(), had.values.size());
      for (std::size_t k = 0; k < had.values.size(); ++k) {
        lost += std::isnan(had.values[k]) ? 1U : 0U;
        if (std::isnan(had.values[k]))
          EXPECT_TRUE(std::isnan(has.values[k])) << had.channel.name << " " << k;
        else
          ASSERT_EQ(std::bit_cast<std::uint32_t>(has.values[k]), std::bit_cast<std::uint32_t>(had.values[k]))
              << had.channel.name << " " << k;
      }
    }
  }
  EXPECT_EQ(lost, 50U * (10U + 1U + 2U + 10U));  // the block of 50 samples that was lost
  expect_same_numbers(session, again);
}

TEST_F(RoundTrip, OfADatasetWithoutCommandsHasNoneAndTheSameEstimates) {
  const auto session = archived(made_up::unloaded_session());
  auto recordings = formats::recordings_of(original_, session).value();
  for (auto& recording : recordings) recording.commanded.clear();
  ASSERT_TRUE(recording::write_dataset(folder_ / "dataset", recordings));
  const auto imported = import_recordings(copy_, recording::read_dataset(folder_ / "dataset").value(),
                                          {"dataset", "0.1.0", 99});
  ASSERT_TRUE(imported) << imported.error().message;
  const auto again = store::read_session(copy_, imported->at(0).session).value();
  ASSERT_FALSE(again.trials.empty());
  for (const auto& trial : again.trials) {
    const auto samples = store::read_trial_samples(copy_, trial);
    ASSERT_TRUE(samples) << samples.error().message;
    for (const auto& sample : samples->samples) ASSERT_FALSE(std::isfinite(sample.commanded_m()[0]));
  }
  const auto estimates = store::newest_estimates(again);
  ASSERT_EQ(estimates.size(), 1U);
  EXPECT_EQ(estimates[0].status(), v1::ESTIMATE_OK);
}

TEST_F(RoundTrip, KeepsLoadedConditionsSetBySet) {
  auto recipe = made_up::unloaded_session();
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
  ASSERT_EQ(store::newest_estimates(session).size(), 4U);
  expect_same_numbers(session, there_and_back(session));
}

TEST_F(RoundTrip, KeepsWhyATrialDoesNotCount) {
  auto recipe = made_up::unloaded_session();
  recipe.rejected_attempt = 6;
  const auto session = archived(std::move(recipe));
  const auto again = there_and_back(session);
  ASSERT_TRUE(again.trials[5].verdict);
  EXPECT_FALSE(again.trials[5].verdict->value.is_valid());
  EXPECT_NE(again.trials[5].verdict->value.detail().find("broken off"), std::string::npos);
  expect_same_numbers(session, again);
}

TEST_F(RoundTrip, KeepsWhichTrialWasRejectedByHandAndTheEstimatesWithoutIt) {
  auto recipe = made_up::unloaded_session();
  recipe.reviewed_attempt = 5;
  const auto session = archived(std::move(recipe));
  const auto again = there_and_back(session);
  EXPECT_NE(store::why_not_counted(again.trials.at(4)).find("rejected by hand by Ada: coughed"),
            std::string::npos)
      << store::why_not_counted(again.trials.at(4));
  expect_same_numbers(session, again);
}

TEST_F(RoundTrip, KeepsWhoWasMeasuredByWhomAndForWhat) {
  auto recipe = made_up::unloaded_session();
  recipe.set_plan = [](v1::SessionPlan& plan) {
    v1::SubjectFacts& facts = plan.subject_facts();
    facts.age_years(31.5);
    facts.sex("female");
    facts.handedness("left");
    facts.measured_arm("right");
    facts.height_m(1.68);
    facts.weight_kg(61.25);
    facts.link_lengths_m({0.302, 0.338});
    facts.circumferences_m({0.281, 0.247});
    facts.shoulder_m({-0.21, 0.4});
    plan.operator_name("Ada");
    plan.study("posture 2026");
    plan.is_pilot(true);
  };
  const auto session = archived(std::move(recipe));
  const auto again = there_and_back(session);
  EXPECT_EQ(again.plan.subject_facts(), session.plan.subject_facts());
  EXPECT_EQ(again.plan.operator_name(), "Ada");
  EXPECT_EQ(again.plan.study(), "posture 2026");
  EXPECT_TRUE(again.plan.is_pilot());
}

TEST_F(RoundTrip, WritesAnAgeOf89AsOneThatNobodyIsKnownBy) {
  auto recipe = made_up::unloaded_session();
  recipe.set_plan = [](v1::SessionPlan& plan) { plan.subject_facts().age_years(89.0); };
  const auto again = there_and_back(archived(std::move(recipe)));
  EXPECT_EQ(again.plan.subject_facts().age_years(), 89.0);
  std::ifstream in(folder_ / "dataset" / "participants.tsv");
  std::stringstream text;
  text << in.rdbuf();
  EXPECT_EQ(text.str(), "participant_id\tage\nsub-07\t89+\n");
}

TEST_F(RoundTrip, OfASubjectWhoCannotBeIsRefusedByName) {
  const auto session = archived(made_up::unloaded_session());
  auto recordings = *formats::recordings_of(original_, session);
  recordings.front().participant.height_m = 178.0;  // cm
  const auto imported = import_recordings(copy_, recordings, {"dataset", "0.1.0", 99});
  ASSERT_FALSE(imported);
  EXPECT_EQ(imported.error().message, "sub-07: height: 178 is not allowed; expected 0.3 to 2.6 m");
}

TEST_F(RoundTrip, WritesANoteAtItsTimeInTheRecordThatItFallsIn) {
  auto recipe = made_up::unloaded_session();
  const auto& second = recipe.trials.at(1);
  v1::SessionNote note;
  note.kind("note");
  note.text("the subject\tis tired");
  note.written_by("Ada");
  note.trial_id(second.report.plan.trial);
  note.has_rig_clock(true);
  note.epoch(second.report.epoch);
  note.rig_clock_ns(second.rows.at(100).raw.acquisition_ns);
  v1::SessionNote outside = note;
  outside.has_rig_clock(false);
  recipe.notes = {note, outside};
  const auto session = archived(std::move(recipe));
  ASSERT_EQ(session.notes.size(), 2U);
  const auto recordings = *formats::recordings_of(original_, session);
  const auto& notes = recordings.at(0).notes;
  ASSERT_FALSE(notes.empty());
  // Made-up trials have clocks of their own that begin anew, so that the note may fall into several of them.
  const auto found = std::ranges::find_if(notes, [](const auto& n) {
    return std::abs(n.onset_s - (650.0 + 100.0) / identification::testing::kRate) < 1e-9;
  });
  ASSERT_NE(found, notes.end());
  EXPECT_EQ(found->trial, 2);
  (void)there_and_back(session);
  std::string row;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "dataset")) {
    if (!entry.path().string().ends_with("_events.tsv")) continue;
    std::ifstream in(entry.path());
    for (std::string line; std::getline(in, line);) {
      if (line.find("\tnote\t2\t") != std::string::npos && line.starts_with("3.75\t")) row = line;
    }
  }
  std::string cells;
  for (int i = 0; i < 13; ++i) cells += "\tn/a";
  EXPECT_EQ(row, "3.75\t0\tnote\t2" + cells + "\tthe subject is tired\tAda");
}

TEST_F(RoundTrip, OfASessionWithLostSamplesMarksThemAsMissing) {
  auto recipe = made_up::unloaded_session();
  recipe.is_block_lost = [](std::uint64_t first) { return first == 3700; };
  const auto session = archived(std::move(recipe));
  const auto recordings = formats::recordings_of(original_, session);
  ASSERT_TRUE(recordings) << recordings.error().message;
  ASSERT_EQ(recordings->size(), 1U);
  const auto missing = std::count_if(recordings->front().rows.begin(), recordings->front().rows.end(),
                                     [](const auto& row) { return row.is_missing; });
  EXPECT_EQ(missing, 50);
}

TEST_F(RoundTrip, WhatWasImportedIsVerified) {
  const auto again = there_and_back(archived(made_up::unloaded_session()));
  const auto v = verification::verify_session(copy_, again.record);
  ASSERT_TRUE(v) << v.error().message;
  EXPECT_TRUE(v->is_well()) << v->problems.front();
  ASSERT_EQ(v->estimates.size(), 1U);
  EXPECT_EQ(v->estimates[0].outcome, verification::EstimateCheck::Outcome::kEqual);
}

TEST_F(RoundTrip, TheSameDatasetIsNotImportedTwice) {
  (void)there_and_back(archived(made_up::unloaded_session()));
  const auto read = recording::read_dataset(folder_ / "dataset");
  ASSERT_TRUE(read);
  const auto twice = import_recordings(copy_, *read, {"dataset", "0.1.0", 100});
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().code, ErrorCode::kAlreadyExists);
  EXPECT_EQ(copy_.sessions()->size(), 1U);
}

TEST_F(RoundTrip, ADatasetThatStatesNoTrialsGivesThePerturbationsWithTheRestBefore) {
  const auto session = archived(made_up::unloaded_session());
  auto recordings = formats::recordings_of(original_, session);
  ASSERT_TRUE(recordings);
  for (auto& record : *recordings) {
    record.phases.clear();
    for (auto& event : record.events) event.trial_onset_s = event.trial_duration_s = std::nullopt;
  }
  const auto imported = import_recordings(copy_, *recordings, {"dataset", "0.1.0", 99});
  ASSERT_TRUE(imported) << imported.error().message;
  const auto again = store::read_session(copy_, imported->at(0).session);
  ASSERT_TRUE(again);
  const auto estimates = store::newest_estimates(*again);
  ASSERT_EQ(estimates.size(), 1U);
  EXPECT_EQ(estimates[0].trials_used(), 16U);
  // The perturbation of 1.75 s with 1 s before it, its end included, at 200 Hz.
  EXPECT_EQ(again->trials[0].record->range().count(), 551U);
}

}  // namespace
}  // namespace tonus::session_import
