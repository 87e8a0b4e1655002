#include "services/archive/wire.hpp"

#include <cstring>
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
  std::uint64_t counter_ = 0;
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
  EXPECT_EQ(stream.expected_samples(), 100U) << "the samples that it speaks of end before through_sequence";
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
  // What contradicts itself is kept all the same: somebody may make sense of it.
  EXPECT_EQ(store_.newest_messages()->size(), 2U);
}

TEST_F(WireTest, DoesNotStoreWhatCannotBeDecoded) {
  v1::ServiceHealth health;
  health.name("made up");
  bus::Payload payload = *bus::encode(health);
  const std::uint32_t length = 0x10000000;  // of the warnings
  // header 4, id 16, role 4, name 4 + 8, host 4 + 1, is_ready 1, padding 2, state 4 + 1, padding 3
  std::memcpy(payload.data() + 52, &length, sizeof length);
  bus::Sample sample;
  sample.payload = std::make_shared<const bus::Payload>(payload);
  const auto fed = feed(ingest_, topics::kServiceHealth.spec, sample, 0);
  ASSERT_FALSE(fed);
  EXPECT_NE(fed.error().message.find("length is 268435456, at most 16 is allowed"), std::string::npos)
      << fed.error().message;
  for (const auto& topic : topics::kAll) {
    if (!is_kept(topic)) continue;
    sample.payload = std::make_shared<const bus::Payload>(32, std::byte{0x01});
    EXPECT_FALSE(feed(ingest_, topic, sample, 0)) << topic.name;
  }
  ASSERT_TRUE(ingest_.finish());
  EXPECT_TRUE(store_.newest_messages()->empty());
}

TEST_F(WireTest, PutsAMessageIntoTheSessionThatItNamesWhateverPlanIsNewest) {
  clock_.advance(std::chrono::hours(24 * 365 * 57));  // 2026
  const Id forged = id_of("forged");
  v1::SessionPlan plan;
  plan.session_id(kSession);
  plan.started_at("2026-03-01T10:00:00Z");
  ASSERT_TRUE(give(topics::kSessionPlan, plan));
  plan.session_id(forged);
  plan.started_at("9999-03-01T10:00:00Z");
  ASSERT_TRUE(give(topics::kSessionPlan, plan));
  v1::TrialVerdict verdict;
  verdict.trial_id(trial_id(kSession, 1));
  verdict.session_id(kSession);
  ASSERT_TRUE(give(topics::kTrialVerdict, verdict));
  v1::ServiceHealth health;  // names no session
  ASSERT_TRUE(give(topics::kServiceHealth, health));
  ASSERT_TRUE(ingest_.finish());
  std::vector<std::string> of_session;
  ASSERT_TRUE(store_.visit_messages({"", kSession, {}}, [&](const store::Message& message) -> Result<void> {
    of_session.push_back(message.topic);
    return {};
  }));
  EXPECT_EQ(of_session, (std::vector<std::string>{"session/plan", "trial/verdict", "service/health"}));
}

TEST_F(WireTest, NoPlanWithAStartThatCannotBeDrawsMessagesToItsSession) {
  clock_.advance(std::chrono::hours(24 * 365 * 57));
  const std::string soon = iso8601(clock_.utc_ns() + 3'600'000'000'000);
  const auto plan = [this](const Id& session, const std::string& started_at) {
    v1::SessionPlan wire;
    wire.session_id(session);
    wire.started_at(started_at);
    ASSERT_TRUE(give(topics::kSessionPlan, wire));
  };
  const std::vector<std::string> absurd{"9999-12-31T23:59:59Z",
                                        "1970-01-01T00:00:00Z",
                                        "-0001-01-01T00:00:00Z",
                                        "",
                                        "zzzz",
                                        "99999-01-01T00:00:00Z",
                                        "2026",
                                        soon};
  const auto session_of_next = [&]() {
    v1::ServiceHealth health;  // names no session
    health.queue_depth(++counter_);
    EXPECT_TRUE(give(topics::kServiceHealth, health));
    EXPECT_TRUE(ingest_.finish());
    Id session{};
    EXPECT_TRUE(
        store_.visit_messages({"service/health", {}, {}}, [&](const store::Message& m) -> Result<void> {
          session = m.session;
          return {};
        }));
    return session;
  };
  for (const std::string& start : absurd) {
    plan(id_of("before " + start), start);
    EXPECT_EQ(session_of_next(), kNoId) << start;
  }
  plan(kSession, "2026-03-01T10:00:00Z");
  for (const std::string& start : absurd) {
    plan(id_of("after " + start), start);
    EXPECT_EQ(session_of_next(), kSession) << start;
  }
  EXPECT_EQ(store_.sessions()->size(), 2 * absurd.size() + 1) << "the plans are kept";
}

TEST_F(WireTest, KeepsEveryTopicButItsOwnReceiptsWhatIsForEyesOnlyAndTheComparingOfClocks) {
  std::vector<std::string> left_out;
  for (const auto& topic : topics::kAll) {
    if (!is_kept(topic)) left_out.emplace_back(topic.name);
  }
  EXPECT_EQ(left_out, (std::vector<std::string>{"estimate/live", "archive/receipt", "clock/probe",
                                                "clock/echo", "rig/stop", "rig/stopped", "rig/lease"}));
}

}  // namespace
}  // namespace tonus::archive
