#include "tests/unit/services/archive/ingest_fixture.hpp"

/// One receipt covers samples and the auxiliary values of their time.
namespace tonus::archive {
namespace {

using store::testing::auxiliary_block_of;
using store::testing::kRig;
using store::testing::kSession;
using store::testing::kStream;
using store::testing::trial_of;

constexpr std::uint32_t kValues = 12;  // six channels at twice the samples' rate

class IngestAuxiliary : public testing::IngestFixture {
 protected:
  void SetUp() override {
    IngestFixture::SetUp();
    ingest_->note_auxiliary(kRig, kValues);
  }

  void take_values(std::uint64_t first, std::uint64_t end, const Id& trial = kNoId, bool is_resent = false) {
    for (; first < end; first += 20) {
      const auto taken = ingest_->take_auxiliary(auxiliary_block_of(first, 20, trial, is_resent), kValues);
      ASSERT_TRUE(taken) << taken.error().message;
    }
  }
};

TEST_F(IngestAuxiliary, AReceiptWaitsForTheValuesOfItsSamples) {
  take_samples(0, 100);
  take_values(0, 60);
  auto decisions = step_after(milliseconds(200));
  ASSERT_EQ(decisions.stream_receipts.size(), 1U);
  EXPECT_EQ(decisions.stream_receipts[0].through, 60U);
  EXPECT_EQ(decisions.stream_receipts[0].counts, (store::Certificate{100, 60, 0, 0, 40}));
  take_values(60, 100);
  decisions = step_after(milliseconds(200));
  ASSERT_EQ(decisions.stream_receipts.size(), 1U);
  EXPECT_EQ(decisions.stream_receipts[0].through, 100U);
}

TEST_F(IngestAuxiliary, AReceiptWaitsForTheSamplesOfValues) {
  take_values(0, 100);
  take_samples(0, 40);
  const auto decisions = step_after(milliseconds(200));
  ASSERT_EQ(decisions.stream_receipts.size(), 1U);
  EXPECT_EQ(decisions.stream_receipts[0].through, 40U);
  EXPECT_EQ(decisions.stream_receipts[0].counts, (store::Certificate{40, 40, 0, 0, 0}))
      << "values alone say nothing of how far the stream reaches";
}

TEST_F(IngestAuxiliary, ATrialIsCertifiedWithItsValues) {
  take_samples(0, 200, trial_id(kSession, 1));
  take_values(0, 100, trial_id(kSession, 1));
  ingest_->note_outcome(trial_of(1, 0, 199));
  EXPECT_TRUE(ingest_->step().trial_receipts.empty());
  take_values(100, 200, trial_id(kSession, 1), true);
  const auto decisions = ingest_->step();
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.trial_receipts[0].certificate, (store::Certificate{200, 200, 100, 0, 0}));
}

TEST_F(IngestAuxiliary, ValuesThatDoNotComeAreRequestedAndThenCountedAsMissing) {
  take_samples(0, 200, trial_id(kSession, 1));
  take_values(0, 80, trial_id(kSession, 1));
  take_values(100, 200, trial_id(kSession, 1));
  ingest_->note_outcome(trial_of(1, 0, 199));
  const auto decisions = pass(std::chrono::seconds(12), 200);
  ASSERT_FALSE(decisions.resends.empty());
  EXPECT_EQ(decisions.resends[0].range, (store::SequenceRange{80, 100}));
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.trial_receipts[0].certificate, (store::Certificate{200, 180, 0, 0, 20}));
}

TEST_F(IngestAuxiliary, ASampleThatIsResentForItsValuesAloneIsADuplicate) {
  take_samples(0, 20, trial_id(kSession, 1));
  take_samples(0, 20, trial_id(kSession, 1), true);
  take_values(0, 20, trial_id(kSession, 1), true);
  ingest_->note_outcome(trial_of(1, 0, 19));
  const auto decisions = ingest_->step();
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.trial_receipts[0].certificate, (store::Certificate{20, 20, 20, 20, 0}));
}

TEST_F(IngestAuxiliary, BlocksThatDoNotFitTheDescriptionAreRefused) {
  EXPECT_FALSE(ingest_->take_auxiliary(auxiliary_block_of(0, 20), kValues - 1));
  const store::StreamKey foreign{id_of("another rig"), 1};
  EXPECT_FALSE(ingest_->take_auxiliary(auxiliary_block_of(0, 20, kNoId, false, foreign), kValues));
  EXPECT_EQ(ingest_->status().waiting_items, 0U);
  take_samples(0, 20);
  const auto decisions = step_after(milliseconds(200));
  EXPECT_TRUE(decisions.stream_receipts.empty()) << "nothing is whole";
}

TEST_F(IngestAuxiliary, AForgedBlockDrawsNothing) {
  take_samples(0, 20);
  take_values(0, 20);
  ASSERT_TRUE(ingest_->take_auxiliary(auxiliary_block_of(std::uint64_t{1} << 40U, 20), kValues));
  const auto decisions = pass(std::chrono::seconds(2), 20);
  EXPECT_TRUE(decisions.resends.empty());
  ASSERT_FALSE(decisions.stream_receipts.empty());
  EXPECT_EQ(decisions.stream_receipts.back().through, 20U);
  EXPECT_EQ(ingest_->status().missing_samples, 0U);
}

TEST_F(IngestAuxiliary, AreKnownAfterARestartBeforeTheRigDescribesItself) {
  take_samples(0, 100);
  take_values(0, 60);
  step_after(milliseconds(200));
  restart();
  EXPECT_EQ(ingest_->step().stream_receipts.at(0).through, 60U);
  take_values(60, 80);
  EXPECT_EQ(step_after(milliseconds(200)).stream_receipts.at(0).through, 80U);
}

TEST_F(IngestAuxiliary, OfANewStartOfTheAgentDoNotChangeWhatTheEarlierOneOwes) {
  take_samples(0, 40);
  take_values(0, 40);
  step_after(milliseconds(200));
  ingest_->note_auxiliary(kRig, 0);
  const store::StreamKey next{kRig, store::testing::kEpoch + 1};
  ingest_->take(store::testing::block_of(0, 20, kNoId, false, next));
  take_samples(40, 60);
  const auto receipts = pass(milliseconds(300), 60).stream_receipts;
  ASSERT_EQ(receipts.size(), 1U);
  EXPECT_EQ(receipts[0].stream, next);
  take_values(40, 60);
  const auto later = pass(milliseconds(300), 60).stream_receipts;
  ASSERT_EQ(later.size(), 1U);
  EXPECT_EQ(later[0].stream, kStream);
  EXPECT_EQ(later[0].through, 60U);
}

TEST_F(IngestAuxiliary, AreLetGoWithTheirSamplesWhileNoSessionGoesOn) {
  options_.idle.ring = std::chrono::seconds(1);
  restart();
  ingest_->note_auxiliary(kRig, kValues);
  std::uint64_t received = 0;
  for (std::uint64_t next = 0; next < 25'000; next += 20) {
    take_samples(next, next + 20);
    take_values(next, next + 20);
    hear_rig(next + 20, received);
    for (const auto& receipt : step_after(milliseconds(20)).stream_receipts) {
      EXPECT_LE(receipt.first, received);
      received = std::max(received, receipt.through);
    }
  }
  EXPECT_GT(received, 15'000U) << "idle, receipts come every 10 s";
  EXPECT_LE(received, 24'000U) << "what is in the ring has no receipt yet";
  int blocks = 0;
  EXPECT_TRUE(
      store_.visit_blocks({kStream, {0, 25'000}, false, true}, [&](const store::Block&) -> Result<void> {
        ++blocks;
        return {};
      }));
  EXPECT_EQ(blocks, 0);
}

}  // namespace
}  // namespace tonus::archive
