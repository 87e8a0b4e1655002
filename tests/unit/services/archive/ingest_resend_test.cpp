#include "tests/unit/services/archive/ingest_fixture.hpp"

/// What is asked for again, and what is refused for want of room.
namespace tonus::archive {
namespace {

using store::testing::block_of;
using store::testing::kRig;
using store::testing::kSession;
using store::testing::kStream;
using store::testing::message_of;
using store::testing::trial_of;

using IngestResend = testing::IngestFixture;

TEST_F(IngestResend, AsksForAGapThatStays) {
  hear_rig(0);
  take_samples(0, 20);
  take_samples(60, 80);
  EXPECT_TRUE(ingest_->step().resends.empty());
  EXPECT_TRUE(step_after(milliseconds(99)).resends.empty());
  const Decisions decisions = step_after(milliseconds(1));
  ASSERT_EQ(decisions.resends.size(), 1U);
  EXPECT_EQ(decisions.resends[0].stream, kStream);
  EXPECT_EQ(decisions.resends[0].range, (store::SequenceRange{20, 60}));
  take_samples(20, 60, kNoId, true);
  EXPECT_TRUE(pass(std::chrono::seconds(5), 80).resends.empty());
}

TEST_F(IngestResend, AsksForTheRestOfATrial) {
  hear_rig(0);
  take_samples(0, 60);
  ingest_->note_outcome(trial_of(1, 0, 99));
  static_cast<void>(ingest_->step());
  const Decisions decisions = step_after(milliseconds(100));
  ASSERT_EQ(decisions.resends.size(), 1U);
  EXPECT_EQ(decisions.resends[0].range, (store::SequenceRange{60, 100}));
}

TEST_F(IngestResend, AsksForWhatTheRigSaysItSent) {
  take_samples(0, 60);
  hear_rig(500);
  static_cast<void>(ingest_->step());
  const Decisions decisions = step_after(milliseconds(100));
  ASSERT_EQ(decisions.resends.size(), 1U);
  EXPECT_EQ(decisions.resends[0].range, (store::SequenceRange{60, 500}));
}

TEST_F(IngestResend, DoesNotAskWhileSamplesFlow) {
  for (std::uint64_t first = 0; first < 2000; first += 20) {
    hear_rig(first + 60);
    take_samples(first, first + 20);
    EXPECT_TRUE(step_after(milliseconds(50)).resends.empty());
  }
}

TEST_F(IngestResend, DoesNotAskForWhatAnotherArchiveHas) {
  hear_rig(5000, 4000);
  take_samples(4000, 5000);
  const Decisions decisions = pass(std::chrono::seconds(4), 5000, 4000);
  EXPECT_TRUE(decisions.resends.empty());
  ASSERT_FALSE(decisions.stream_receipts.empty());
  EXPECT_EQ(decisions.stream_receipts[0].through, 5000U);
  EXPECT_EQ(decisions.stream_receipts[0].counts, (store::Certificate{1000, 1000, 0, 0, 0}));
  EXPECT_EQ((*store_.streams())[0].origin, 4000U);
}

TEST_F(IngestResend, GivesNoReceiptForATrialThatAnotherArchiveHasInPart) {
  ingest_->note_outcome(trial_of(1, 3900, 4099));
  hear_rig(5000, 4000);
  take_samples(4000, 5000);
  const Decisions decisions = pass(std::chrono::seconds(5), 5000, 4000);
  EXPECT_TRUE(decisions.trial_receipts.empty());
}

TEST_F(IngestResend, GivesNoReceiptForWhatOnlyAMessageClaims) {
  // A forged state before any sample, and between the rig's own.
  hear_rig(1'000'000, 1'000'000);
  EXPECT_TRUE(pass(std::chrono::seconds(20), 1'000'000, 1'000'000).stream_receipts.empty());
  take_samples(0, 400);
  const Decisions before = pass(std::chrono::seconds(1), 400);
  ASSERT_FALSE(before.stream_receipts.empty()) << "the rig's word withdraws the forged one";
  EXPECT_EQ(before.stream_receipts.back().through, 400U);
  std::uint64_t through = 0;
  for (std::uint64_t end = 420; end < 2000; end += 20) {
    hear_rig(900'020, 900'000);
    take_samples(900'000, 900'020);  // forged with it
    for (const auto& receipt : ingest_->step().stream_receipts) through = receipt.through;
    EXPECT_LE(through, end - 20);
    take_samples(end - 20, end);
    for (const auto& receipt : pass(milliseconds(250), end).stream_receipts) through = receipt.through;
    EXPECT_LE(through, end);
  }
  EXPECT_EQ(through, 1980U);
}

TEST_F(IngestResend, AsksOnlyARigThatWasHeardOf) {
  take_samples(0, 20);
  take_samples(60, 80);
  step_after(milliseconds(200));
  restart();
  EXPECT_TRUE(step_after(milliseconds(100)).resends.empty());
  EXPECT_TRUE(step_after(milliseconds(5000)).resends.empty());
  hear_rig(100);
  EXPECT_TRUE(ingest_->step().resends.empty());
  EXPECT_EQ(step_after(milliseconds(100)).resends.size(), 2U);
}

TEST_F(IngestResend, AsksARigThatCameBackAnew) {
  hear_rig(100);
  const Decisions before = pass(std::chrono::seconds(20), 100);
  EXPECT_LT(before.resends.size(), 12U);
  clock_.advance(std::chrono::seconds(5));
  static_cast<void>(ingest_->step());
  ingest_->note_rig({{kRig, store::testing::kEpoch + 1}, 0, 0});
  static_cast<void>(ingest_->step());
  const Decisions decisions = step_after(milliseconds(100));
  ASSERT_EQ(decisions.resends.size(), 1U);
  EXPECT_EQ(decisions.resends[0].stream, kStream);
}

TEST_F(IngestResend, RefusesBlocksItHasNoRoomForAndAsksForThemLater) {
  options_.backlog_bytes = 200;
  restart();
  store_.is_failing = true;
  hear_rig(0);
  take_samples(0, 2000);
  step_after(milliseconds(200));
  const IngestStatus full = ingest_->status();
  EXPECT_LE(full.waiting_bytes, 200U);
  EXPECT_GT(full.refused_blocks, 50U);
  EXPECT_EQ(full.lost_messages, 0U);
  EXPECT_TRUE(pass(std::chrono::seconds(3), 2000).resends.empty());  // no use while the store fails

  store_.is_failing = false;
  const Decisions decisions = pass(std::chrono::seconds(1), 2000);
  ASSERT_FALSE(decisions.resends.empty());
  EXPECT_EQ(decisions.resends[0].range.end, 2000U);
  EXPECT_EQ(decisions.resends[0].range.first, decisions.stream_receipts.at(0).through);
}

TEST_F(IngestResend, CountsMessagesItHasNoRoomFor) {
  options_.backlog_bytes = 100;
  restart();
  store_.is_failing = true;
  for (int i = 0; i < 30; ++i) ingest_->take(message_of("rig/command", kRig, "ten octets"), false);
  EXPECT_EQ(ingest_->status().lost_messages, 10U);
  EXPECT_EQ(ingest_->status().waiting_bytes, 200U);
}

TEST_F(IngestResend, AForgedStateIsForgottenWithTheNextTrueOne) {
  take_samples(0, 100);
  hear_rig(std::uint64_t{1} << 61U);
  EXPECT_GT(ingest_->status().missing_samples, 1'000'000U);
  hear_rig(100);
  EXPECT_EQ(ingest_->status().missing_samples, 0U);
  EXPECT_TRUE(pass(std::chrono::seconds(2), 100).resends.empty());
}

TEST_F(IngestResend, AForgedOutcomeIsAskedForUntilItIsGivenUpAndMakesNoReceiptForItsSamples) {
  take_samples(0, 100);
  ingest_->note_outcome(store::testing::trial_of(7, 0, std::uint64_t{1} << 60U));
  const Decisions all = pass(std::chrono::seconds(12), 100);
  EXPECT_LT(all.resends.size(), 20U);
  ASSERT_EQ(all.trial_receipts.size(), 1U);
  EXPECT_EQ(all.trial_receipts[0].certificate.received, 100U);
  EXPECT_GT(all.trial_receipts[0].certificate.missing, 0U);
  for (const StreamReceipt& receipt : all.stream_receipts) EXPECT_LE(receipt.through, 100U);
  EXPECT_EQ(ingest_->status().missing_samples, 0U) << "it no longer counts";
  EXPECT_TRUE(pass(std::chrono::seconds(30), 100).resends.empty());
}

TEST_F(IngestResend, ATrialIsAskedForAlsoWhereAForgedStateHasMovedTheOrigin) {
  take_samples(0, 40);
  hear_rig(100, 80);  // forged: receipts of another archive for what never came
  ingest_->note_outcome(store::testing::trial_of(1, 20, 99));
  std::vector<ResendRequest> requests;
  for (int i = 0; i < 10; ++i) {
    hear_rig(100, 80);
    const auto resends = step_after(milliseconds(50)).resends;
    requests.insert(requests.end(), resends.begin(), resends.end());
  }
  ASSERT_FALSE(requests.empty());
  EXPECT_EQ(requests[0].range, (store::SequenceRange{40, 100}));
}

TEST_F(IngestResend, AReceiptNamesItsFirstSampleSoThatARigSeesWhatItLeavesOut) {
  take_samples(0, 40);
  take_samples(100, 200);
  hear_rig(200, 100);  // forged, while the rig is away
  const Decisions all = pass(std::chrono::seconds(4), 200, 100);
  ASSERT_FALSE(all.stream_receipts.empty());
  EXPECT_EQ(all.stream_receipts.back().first, 100U);
  EXPECT_EQ(all.stream_receipts.back().through, 200U);
}

}  // namespace
}  // namespace tonus::archive
