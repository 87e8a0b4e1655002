#include "services/archive/wire.hpp"

#include <gtest/gtest.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/core/crc32c.hpp"
#include "services/store/memory_store.hpp"
#include "tests/unit/services/store/made_up.hpp"

namespace tonus::archive {
namespace {

using store::testing::kEpoch;
using store::testing::kRig;
using store::testing::kSession;

class WireTest : public ::testing::Test {
 protected:
  template <typename T>
  Result<void> give(const bus::Topic<T>& topic, const T& value) {
    bus::Sample sample;
    sample.payload = std::make_shared<const bus::Payload>(*bus::encode(value));
    std::copy_n(reinterpret_cast<const std::uint8_t*>(sample.payload->data()) + 4, sample.key.size(),
                sample.key.begin());
    last_ = sample;
    return feed(ingest_, topic.spec, sample, 123);
  }

  static v1::SampleBlock samples(std::uint64_t first, std::size_t count) {
    v1::SampleBlock block;
    block.rig_id(kRig);
    block.session_id(kSession);
    block.trial_id(trial_id(kSession, 1));
    block.epoch(kEpoch);
    block.first_sequence(first);
    block.samples().resize(count);
    return block;
  }

  static v1::TrialOutcome outcome(std::uint64_t first, std::uint64_t last) {
    v1::TrialOutcome wire;
    wire.trial_id(trial_id(kSession, 1));
    wire.program().session_id(kSession);
    wire.program().rig_id(kRig);
    wire.program().attempt(1);
    wire.program().posture("left");
    wire.epoch(kEpoch);
    wire.end(v1::TRIAL_COMPLETED);
    wire.first_sequence(first);
    wire.onset_sequence(first);
    wire.last_sequence(last);
    return wire;
  }

  store::MemoryStore store_;
  ManualClock clock_;
  Ingest ingest_{store_, clock_};
  bus::Sample last_;
};

TEST_F(WireTest, KeepsSamplesAsTheyCameWithTheirChecksum) {
  ASSERT_TRUE(give(topics::kRigSamples, samples(0, 20)));
  const bus::Sample sent = last_;
  ASSERT_TRUE(ingest_.finish());
  int count = 0;
  ASSERT_TRUE(store_.visit_blocks({{kRig, kEpoch}, {0, 20}}, [&](const store::Block& block) -> Result<void> {
    ++count;
    EXPECT_EQ(*block.payload, *sent.payload);
    EXPECT_EQ(block.checksum, crc32c(*sent.payload));
    EXPECT_EQ(block.count, 20U);
    EXPECT_EQ(block.trial, trial_id(kSession, 1));
    EXPECT_EQ(block.session, kSession);
    EXPECT_EQ(block.received_ns, 123U);
    return {};
  }));
  EXPECT_EQ(count, 1);
}

TEST_F(WireTest, MakesReceiptsOfOutcomes) {
  ASSERT_TRUE(give(topics::kRigSamples, samples(0, 100)));
  ASSERT_TRUE(give(topics::kTrialOutcome, outcome(0, 99)));
  const Decisions decisions = ingest_.step();
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  const v1::ArchiveReceipt trial = to_wire(decisions.trial_receipts[0]);
  EXPECT_EQ(trial.kind(), v1::RECEIPT_TRIAL);
  EXPECT_EQ(trial.subject_id(), trial_id(kSession, 1));
  EXPECT_EQ(trial.rig_id(), kRig);
  EXPECT_EQ(trial.session_id(), kSession);
  EXPECT_EQ(trial.epoch(), kEpoch);
  EXPECT_EQ(trial.through_sequence(), 100U);
  EXPECT_EQ(trial.expected_samples(), 100U);
  EXPECT_EQ(trial.received_samples(), 100U);
  EXPECT_EQ(trial.missing_samples(), 0U);
  const v1::ArchiveReceipt stream = to_wire(decisions.stream_receipts.at(0));
  EXPECT_EQ(stream.kind(), v1::RECEIPT_STREAM);
  EXPECT_EQ(stream.subject_id(), kRig);
  EXPECT_EQ(stream.through_sequence(), 100U);
  EXPECT_EQ((*store_.find_trial(trial_id(kSession, 1)))->posture, "left");
}

TEST_F(WireTest, AsksForWhatTheRigsStateTells) {
  v1::RigState state;
  state.rig_id(kRig);
  state.epoch(kEpoch);
  state.next_sequence(60);
  ASSERT_TRUE(give(topics::kRigState, state));
  EXPECT_TRUE(ingest_.step().resends.empty());
  clock_.advance(std::chrono::milliseconds(100));
  const Decisions decisions = ingest_.step();
  ASSERT_EQ(decisions.resends.size(), 1U);
  const v1::ArchiveResend request = to_wire(decisions.resends[0]);
  EXPECT_EQ(request.rig_id(), kRig);
  EXPECT_EQ(request.epoch(), kEpoch);
  EXPECT_EQ(request.first_sequence(), 0U);
  EXPECT_EQ(request.last_sequence(), 59U);
}

TEST_F(WireTest, PutsAPlanAndItsMessageIntoItsOwnSession) {
  v1::SessionPlan plan;
  plan.session_id(kSession);
  plan.subject("sub-01");
  plan.started_at("2026-03-01T10:00:00Z");
  ASSERT_TRUE(give(topics::kSessionPlan, plan));
  ASSERT_TRUE(ingest_.finish());
  EXPECT_EQ(store_.sessions()->at(0).subject, "sub-01");
  int count = 0;
  ASSERT_TRUE(store_.visit_messages({"session/plan", kSession, kSession},
                                    [&count](const store::Message&) -> Result<void> {
                                      ++count;
                                      return {};
                                    }));
  EXPECT_EQ(count, 1);
}

TEST_F(WireTest, RefusesNonsenseWithoutHarm) {
  EXPECT_FALSE(give(topics::kRigSamples, samples(0, 0)));
  EXPECT_FALSE(give(topics::kRigSamples, samples(~std::uint64_t{0} - 5, 20)));
  EXPECT_FALSE(give(topics::kTrialOutcome, outcome(10, 9)));
  EXPECT_FALSE(give(topics::kTrialOutcome, outcome(0, ~std::uint64_t{0})));
  v1::RigState state;
  state.rig_id(kRig);
  state.next_sequence(10);
  state.received_through(11);
  EXPECT_FALSE(give(topics::kRigState, state));
  bus::Sample cut = last_;
  cut.payload = std::make_shared<const bus::Payload>(last_.payload->begin(), last_.payload->begin() + 24);
  EXPECT_FALSE(feed(ingest_, topics::kRigState.spec, cut, 0));
  EXPECT_FALSE(feed(ingest_, topics::kRigSamples.spec, cut, 0));
  EXPECT_TRUE(ingest_.step().trial_receipts.empty());
  ASSERT_TRUE(ingest_.finish());
  EXPECT_TRUE(store_.streams()->empty());
  // What is no sample is kept all the same: somebody may make sense of it.
  EXPECT_EQ(store_.newest_messages()->size(), 2U);
}

TEST_F(WireTest, KeepsEveryTopicButItsOwnReceiptsWhatIsForEyesOnlyAndTheComparingOfClocks) {
  std::vector<std::string> left_out;
  for (const auto& topic : topics::kAll) {
    if (!is_kept(topic)) left_out.emplace_back(topic.name);
  }
  EXPECT_EQ(left_out,
            (std::vector<std::string>{"estimate/live", "archive/receipt", "clock/probe", "clock/echo"}));
}

}  // namespace
}  // namespace tonus::archive
