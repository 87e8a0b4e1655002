#include "tests/unit/services/archive/ingest_fixture.hpp"

/// What an archive does that comes back.
namespace tonus::archive {
namespace {

using store::testing::block_of;
using store::testing::kSession;
using store::testing::kStream;
using store::testing::message_of;
using store::testing::session_of;
using store::testing::trial_of;

using IngestRecovery = testing::IngestFixture;

TEST_F(IngestRecovery, AsksForWhatCameWhileItWasGone) {
  take_samples(0, 100);
  step_after(milliseconds(200));
  take_samples(100, 200);  // dies with it
  restart();
  hear_rig(600);
  static_cast<void>(ingest_->step());
  const Decisions decisions = step_after(milliseconds(100));
  ASSERT_EQ(decisions.resends.size(), 1U);
  EXPECT_EQ(decisions.resends[0].range, (store::SequenceRange{100, 600}));
}

TEST_F(IngestRecovery, GivesTheReceiptsOfTheNewestSessionOnceMore) {
  const Id earlier = id_of("earlier session");
  store::TrialRecord other = trial_of(9, 200, 299);
  other.trial = trial_id(earlier, 9);
  other.session = earlier;
  ingest_->note_plan(session_of(earlier, "2026-03-01T09:00:00Z"));
  ingest_->note_plan(session_of(kSession, "2026-03-01T10:00:00Z"));
  take_samples(0, 300);
  ingest_->note_outcome(other);
  ingest_->note_outcome(trial_of(1, 0, 99));
  ingest_->note_outcome(trial_of(2, 100, 499));
  EXPECT_EQ(ingest_->step().trial_receipts.size(), 2U);
  restart();
  const Decisions decisions = ingest_->step();
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.trial_receipts[0].trial, trial_id(kSession, 1));
  EXPECT_EQ(decisions.trial_receipts[0].certificate, (store::Certificate{100, 100, 0, 0, 0}));
  ASSERT_EQ(decisions.stream_receipts.size(), 1U);
  EXPECT_EQ(decisions.stream_receipts[0].through, 300U);

  take_samples(300, 500, kNoId, true);  // the one that was under way
  EXPECT_EQ(ingest_->step().trial_receipts.size(), 1U);
}

TEST_F(IngestRecovery, KeepsCountingWhereItStopped) {
  const Id trial = trial_id(kSession, 1);
  take_samples(0, 40, trial);
  take_samples(20, 40, trial);
  take_samples(40, 60, trial, true);
  step_after(milliseconds(200));
  restart();
  take_samples(60, 100, trial, true);
  take_samples(60, 80, trial);
  ingest_->note_outcome(trial_of(1, 0, 99));
  const Decisions decisions = ingest_->step();
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.trial_receipts[0].certificate, (store::Certificate{100, 100, 60, 40, 0}));
  EXPECT_TRUE(store_.tallies()->empty());
}

TEST_F(IngestRecovery, KnowsTheStatesThatItHas) {
  ingest_->take(message_of("trial/verdict", id_of("1"), "valid"), true);
  step_after(milliseconds(200));
  EXPECT_EQ(store_.commits, 1);
  restart();
  ingest_->take(message_of("trial/verdict", id_of("1"), "valid"), true);
  step_after(milliseconds(200));
  EXPECT_EQ(store_.commits, 1);
}

TEST_F(IngestRecovery, TakesTheNewestSessionWhateverComesFirst) {
  ingest_->note_plan(session_of(kSession, "2026-03-01T10:00:00Z"));
  ingest_->note_plan(session_of(id_of("earlier session"), "2026-03-01T09:00:00Z"));
  ingest_->take(message_of("rig/command", id_of("1"), "stop"), false);
  step_after(milliseconds(200));
  EXPECT_EQ(store_.last.messages.at(0).session, kSession);
  EXPECT_EQ(store_.sessions()->size(), 2U);
}

TEST_F(IngestRecovery, StoresWhatWaitsAtAnOrderlyEnd) {
  take_samples(0, 100);
  ASSERT_TRUE(ingest_->finish());
  EXPECT_EQ((*store_.streams())[0].coverage.end(), 100U);
  restart();
  EXPECT_EQ(ingest_->step().stream_receipts.at(0).through, 100U);
  store_.is_failing = true;
  take_samples(100, 200);
  const auto finished = ingest_->finish();
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().message, "store 'made up': disk is full");
}

}  // namespace
}  // namespace tonus::archive
