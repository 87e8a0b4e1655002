#include "tests/unit/services/archive/ingest_fixture.hpp"

/// When things become durable, and which receipts follow.
namespace tonus::archive {
namespace {

using store::testing::block_of;
using store::testing::kSession;
using store::testing::kStream;
using store::testing::message_of;
using store::testing::session_of;
using store::testing::trial_of;

using IngestReceipts = testing::IngestFixture;

TEST_F(IngestReceipts, AreGivenAtOnceForATrialThatIsWhole) {
  take_samples(0, 1400, trial_id(kSession, 1));
  ingest_->note_outcome(trial_of(1, 0, 1399));
  const Decisions decisions = ingest_->step();
  EXPECT_EQ(store_.commits, 1);
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  const TrialReceipt& receipt = decisions.trial_receipts[0];
  EXPECT_EQ(receipt.trial, trial_id(kSession, 1));
  EXPECT_EQ(receipt.session, kSession);
  EXPECT_EQ(receipt.stream, kStream);
  EXPECT_EQ(receipt.through, 1400U);
  EXPECT_EQ(receipt.certificate, (store::Certificate{1400, 1400, 0, 0, 0}));
  ASSERT_EQ(decisions.stream_receipts.size(), 1U);
  EXPECT_EQ(decisions.stream_receipts[0].through, 1400U);
  EXPECT_TRUE(store_.last.trials.at(0).is_certified);
  EXPECT_EQ(store_.last.blocks.size(), 70U);
}

TEST_F(IngestReceipts, FollowTheOutcomeWhateverComesFirst) {
  ingest_->note_outcome(trial_of(1, 0, 99));
  EXPECT_TRUE(ingest_->step().trial_receipts.empty());
  take_samples(40, 100);
  EXPECT_TRUE(ingest_->step().trial_receipts.empty());
  take_samples(0, 40);
  EXPECT_EQ(ingest_->step().trial_receipts.size(), 1U);
}

TEST_F(IngestReceipts, AreGivenOutsideTrialsAtTheCommitInterval) {
  take_samples(0, 100);
  Decisions decisions = ingest_->step();
  EXPECT_EQ(store_.commits, 0);
  EXPECT_TRUE(decisions.stream_receipts.empty());
  EXPECT_EQ(decisions.due, clock_.now() + milliseconds(200));
  decisions = step_after(milliseconds(200));
  EXPECT_EQ(store_.commits, 1);
  ASSERT_EQ(decisions.stream_receipts.size(), 1U);
  EXPECT_EQ(decisions.stream_receipts[0].through, 100U);
  EXPECT_EQ(decisions.stream_receipts[0].counts, (store::Certificate{100, 100, 0, 0, 0}));
  EXPECT_TRUE(step_after(milliseconds(500)).stream_receipts.empty());
  EXPECT_EQ(store_.commits, 1);
}

TEST_F(IngestReceipts, AreGivenWhenMuchWaits) {
  options_.commit_bytes = 100;
  restart();
  take_samples(0, 200);
  EXPECT_EQ(ingest_->step().stream_receipts.size(), 1U);
}

TEST_F(IngestReceipts, CoverOnlyWhatIsWholeFromTheStart) {
  take_samples(0, 100);
  take_samples(140, 200);
  const Decisions decisions = step_after(milliseconds(200));
  ASSERT_EQ(decisions.stream_receipts.size(), 1U);
  EXPECT_EQ(decisions.stream_receipts[0].through, 100U);
  EXPECT_EQ(decisions.stream_receipts[0].counts, (store::Certificate{200, 160, 0, 0, 40}));
}

TEST_F(IngestReceipts, AreNotGivenBeforeTheStoreTookTheData) {
  store_.is_failing = true;
  take_samples(0, 100, trial_id(kSession, 1));
  ingest_->note_outcome(trial_of(1, 0, 99));
  Decisions decisions = ingest_->step();
  EXPECT_TRUE(decisions.trial_receipts.empty());
  EXPECT_TRUE(decisions.stream_receipts.empty());
  EXPECT_EQ(ingest_->status().failure, "store 'made up': disk is full");
  EXPECT_EQ(store_.refused, 1);
  EXPECT_EQ(decisions.due, clock_.now() + milliseconds(500));
  EXPECT_TRUE(step_after(milliseconds(499)).trial_receipts.empty());
  EXPECT_EQ(store_.refused, 1);

  store_.is_failing = false;
  decisions = step_after(milliseconds(1));
  EXPECT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.stream_receipts.size(), 1U);
  EXPECT_EQ(ingest_->status().failure, "");
  EXPECT_EQ(store_.last.blocks.size(), 5U);
}

TEST_F(IngestReceipts, CountWhatCameTwiceAndWhatWasSentAgain) {
  const Id trial = trial_id(kSession, 1);
  take_samples(0, 60, trial);
  take_samples(40, 60, trial);         // 20 twice
  take_samples(60, 100, trial, true);  // 40 sent again, new here
  take_samples(80, 100, trial, true);  // 20 of them twice
  ingest_->note_outcome(trial_of(1, 0, 99));
  const Decisions decisions = ingest_->step();
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.trial_receipts[0].certificate, (store::Certificate{100, 100, 40, 40, 0}));
  EXPECT_EQ(store_.last.blocks.size(), 5U);  // what was there already is not stored again
}

TEST_F(IngestReceipts, TakePartlyNewBlocksWhole) {
  take_samples(0, 20);
  ingest_->take(block_of(10, 20));
  const Decisions decisions = step_after(milliseconds(200));
  EXPECT_EQ(store_.last.blocks.size(), 2U);
  EXPECT_EQ(decisions.stream_receipts.at(0).counts, (store::Certificate{30, 30, 0, 10, 0}));
}

TEST_F(IngestReceipts, DoNotDependOnTheOrderOfArrival) {
  for (const std::uint64_t first : {80, 20, 0, 60, 40})
    take_samples(first, first + 20, trial_id(kSession, 1));
  ingest_->note_outcome(trial_of(1, 0, 99));
  const Decisions decisions = ingest_->step();
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.trial_receipts[0].certificate, (store::Certificate{100, 100, 0, 0, 0}));
}

TEST_F(IngestReceipts, AreGivenAgainWhenTheOutcomeComesAgain) {
  take_samples(0, 100);
  ingest_->note_outcome(trial_of(1, 0, 99));
  EXPECT_EQ(ingest_->step().trial_receipts.size(), 1U);
  ingest_->note_outcome(trial_of(1, 0, 99));
  const Decisions again = ingest_->step();
  ASSERT_EQ(again.trial_receipts.size(), 1U);
  EXPECT_EQ(again.trial_receipts[0].certificate, (store::Certificate{100, 100, 0, 0, 0}));
}

TEST_F(IngestReceipts, AreGivenForATrialThatNeverBegan) {
  store::TrialRecord refused = trial_of(1, 0, 0);
  refused.has_samples = false;
  ingest_->note_outcome(refused);
  const Decisions decisions = ingest_->step();
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.trial_receipts[0].certificate, (store::Certificate{0, 0, 0, 0, 0}));
}

TEST_F(IngestReceipts, AreGivenAgainToARigThatDoesNotKnowThem) {
  take_samples(0, 100);
  EXPECT_EQ(step_after(milliseconds(200)).stream_receipts.size(), 1U);
  hear_rig(100, 0);
  EXPECT_TRUE(step_after(milliseconds(100)).stream_receipts.empty());  // it may be on its way
  clock_.advance(milliseconds(500));
  hear_rig(100, 0);
  EXPECT_EQ(ingest_->step().stream_receipts.size(), 1U);
  clock_.advance(milliseconds(500));
  hear_rig(100, 100);
  EXPECT_TRUE(ingest_->step().stream_receipts.empty());
  clock_.advance(milliseconds(500));
  take_samples(40, 60, kNoId, true);  // sent again although it is here
  EXPECT_EQ(ingest_->step().stream_receipts.size(), 1U);
}

TEST_F(IngestReceipts, SayWhatIsMissingWhenNothingMoreComes) {
  take_samples(0, 80);
  ingest_->note_outcome(trial_of(1, 0, 99));
  EXPECT_TRUE(pass(std::chrono::seconds(10), 100).trial_receipts.empty());
  const Decisions decisions = pass(milliseconds(500), 100);
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.trial_receipts[0].certificate, (store::Certificate{100, 80, 0, 0, 20}));
  EXPECT_FALSE((*store_.find_trial(trial_id(kSession, 1)))->is_certified);
  EXPECT_TRUE(pass(std::chrono::seconds(20), 100).trial_receipts.empty());

  take_samples(80, 100, kNoId, true);  // it came all the same
  const Decisions late = ingest_->step();
  ASSERT_EQ(late.trial_receipts.size(), 1U);
  EXPECT_EQ(late.trial_receipts[0].certificate.missing, 0U);
}

TEST_F(IngestReceipts, WaitForARigThatIsGone) {
  take_samples(0, 80);
  ingest_->note_outcome(trial_of(1, 0, 99));
  static_cast<void>(ingest_->step());
  for (int s = 0; s < 60; ++s) EXPECT_TRUE(step_after(std::chrono::seconds(1)).trial_receipts.empty());
}

TEST_F(IngestReceipts, ComeWithMessagesOfTheSessionInForce) {
  ingest_->note_plan(session_of(kSession, "2026-03-01T10:00:00Z"));
  ingest_->take(message_of("trial/verdict", id_of("1"), "valid"), true);
  take_samples(0, 20);
  const Decisions decisions = step_after(milliseconds(200));
  EXPECT_EQ(store_.last.messages.at(0).session, kSession);
  EXPECT_EQ(store_.last.sessions.at(0).session, kSession);
  EXPECT_EQ(decisions.stream_receipts.at(0).session, kSession);
}

TEST_F(IngestReceipts, KeepEveryMessageButRepeatedStates) {
  ingest_->take(message_of("trial/verdict", id_of("1"), "valid"), true);
  ingest_->take(message_of("trial/verdict", id_of("1"), "valid"), true);
  ingest_->take(message_of("trial/verdict", id_of("2"), "valid"), true);
  ingest_->take(message_of("rig/command", id_of("1"), "stop"), false);
  ingest_->take(message_of("rig/command", id_of("1"), "stop"), false);
  ingest_->take(message_of("trial/verdict", id_of("1"), "invalid"), true);
  ingest_->take(message_of("trial/verdict", id_of("1"), "valid"), true);
  step_after(milliseconds(200));
  EXPECT_EQ(store_.last.messages.size(), 6U);
}

TEST_F(IngestReceipts, AreGivenForOneStreamOfARigAtATime) {
  const store::StreamKey older{store::testing::kRig, 1};
  ingest_->take(block_of(0, 20, kNoId, true, older));
  ingest_->take(block_of(0, 20));
  const Decisions first = step_after(milliseconds(200));
  ASSERT_EQ(first.stream_receipts.size(), 1U);
  EXPECT_EQ(first.stream_receipts[0].stream, older);
  EXPECT_EQ(first.due, clock_.now() + milliseconds(20));
  const Decisions second = step_after(milliseconds(20));
  ASSERT_EQ(second.stream_receipts.size(), 1U);
  EXPECT_EQ(second.stream_receipts[0].stream, kStream);
}

}  // namespace
}  // namespace tonus::archive
