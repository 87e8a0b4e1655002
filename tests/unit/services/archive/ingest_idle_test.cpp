#include "tests/unit/services/archive/ingest_fixture.hpp"

#include <idl/session.h>

/// Without a session hardly anything is stored, and the rig gets its receipts all the same.
namespace tonus::archive {
namespace {

using std::chrono::seconds;
using store::testing::kRig;
using store::testing::kSession;
using store::testing::message_of;
using store::testing::session_of;
using store::testing::trial_of;

class IngestIdle : public testing::IngestFixture {
 protected:
  void SetUp() override {
    options_.idle.ring = seconds(60);
    IngestFixture::SetUp();
  }

  /// A rig at 20 samples in 20 ms that reports what it has receipts for, as rigs do.
  void live(Clock::Duration duration, bool is_faulted = false) {
    for (Clock::Duration passed{}; passed < duration; passed += milliseconds(20)) {
      take_samples(next_, next_ + 20);
      next_ += 20;
      ingest_->note_rig({store::testing::kStream, next_, received_, is_faulted});
      const std::string state = "state at " + std::to_string(next_);
      ingest_->take(message_of("rig/state", kRig, state), true);
      const Decisions decisions = step_after(milliseconds(20));
      for (const StreamReceipt& receipt : decisions.stream_receipts) {
        EXPECT_LE(receipt.first, received_) << "the rig would not take it";
        received_ = std::max(received_, receipt.through);
      }
      resends_ += decisions.resends.size();
    }
  }

  std::size_t stored_samples() {
    std::size_t samples = 0;
    EXPECT_TRUE(store_.visit_blocks({store::testing::kStream, {0, next_}}, [&](const store::Block& block) {
      samples += block.count;
      return Result<void>();
    }));
    return samples;
  }

  std::size_t stored_messages(const std::string& topic) {
    std::size_t messages = 0;
    EXPECT_TRUE(store_.visit_messages({topic, {}, {}}, [&](const store::Message&) {
      ++messages;
      return Result<void>();
    }));
    return messages;
  }

  std::uint64_t next_ = 0;
  std::uint64_t received_ = 0;
  std::size_t resends_ = 0;
};

TEST_F(IngestIdle, StoresNoSampleAndTheRigStillGetsItsReceipts) {
  live(seconds(300));
  EXPECT_EQ(stored_samples(), 0U);
  EXPECT_GT(received_, next_ - 75'000) << "the ring's minute, and the commit every 10 s";
  EXPECT_EQ(resends_, 0U);
  EXPECT_EQ(ingest_->status().missing_samples, 0U);
  const int commits = store_.commits;
  live(seconds(100));
  EXPECT_LE(store_.commits - commits, 15) << "the disk is let alone, too";
  EXPECT_EQ(store_.streams()->at(0).coverage.ranges().size(), 0U) << "the archive does not grow";
}

TEST_F(IngestIdle, StatesAreStoredOnceAMinuteAndTheNewestWhenASessionBegins) {
  live(seconds(300));
  EXPECT_LE(stored_messages("rig/state"), 6U);
  EXPECT_GE(stored_messages("rig/state"), 4U);
  live(seconds(7));
  ingest_->note_plan(session_of(kSession, "2026-03-01T10:00:00Z"));
  ASSERT_TRUE(ingest_->finish());
  std::string newest;
  ASSERT_TRUE(store_.visit_messages({"rig/state", {}, {}}, [&](const store::Message& message) {
    newest.assign(reinterpret_cast<const char*>(message.payload->data()), message.payload->size());
    return Result<void>();
  }));
  EXPECT_EQ(newest, "state at " + std::to_string(next_));
}

TEST_F(IngestIdle, StoresEverySampleFromASessionsPlanToItsEnd) {
  live(seconds(100));
  const std::uint64_t begin = next_;
  ingest_->note_plan(session_of(kSession, "2026-03-01T10:00:00Z"));
  live(seconds(5));
  const std::uint64_t first = next_;
  take_samples(next_, next_ + 200, trial_id(kSession, 1));
  next_ += 200;
  ingest_->note_outcome(trial_of(1, first, next_ - 1));
  live(seconds(5));
  const std::uint64_t end = next_;
  ingest_->note_session_end(kSession, v1::SESSION_COMPLETED);
  live(seconds(300));
  EXPECT_EQ(stored_samples(), end - begin);
  EXPECT_TRUE(store_.streams()->at(0).coverage.covers({begin, end}));
  EXPECT_TRUE((*store_.find_trial(trial_id(kSession, 1)))->is_certified);
  EXPECT_GT(received_, next_ - 75'000);
  EXPECT_EQ(resends_, 0U);
}

TEST_F(IngestIdle, ATrialsSamplesAreStoredThoughNoPlanIsKnown) {
  live(seconds(1));
  take_samples(next_, next_ + 200, trial_id(kSession, 1));
  ingest_->note_outcome(trial_of(1, next_, next_ + 199));
  next_ += 200;
  const Decisions decisions = step_after(milliseconds(1));
  ASSERT_EQ(decisions.trial_receipts.size(), 1U);
  EXPECT_EQ(decisions.trial_receipts[0].certificate.missing, 0U);
  EXPECT_EQ(stored_samples(), 200U);
}

TEST_F(IngestIdle, NoTrialIsCertifiedBySamplesThatWereLetGo) {
  live(seconds(100));
  ingest_->note_outcome(trial_of(1, 0, 999));
  live(seconds(20));
  const auto trial = *store_.find_trial(trial_id(kSession, 1));
  ASSERT_TRUE(trial);
  EXPECT_FALSE(trial->is_certified);
  EXPECT_EQ(trial->certificate.missing, 1000U);
}

TEST_F(IngestIdle, StoresWhatPrecedesAndFollowsAFault) {
  live(seconds(30));
  live(seconds(20), true);
  EXPECT_GE(stored_samples(), 14'900U) << "10 s before and 5 s after";
  EXPECT_LE(stored_samples(), 15'100U);
  live(seconds(100), true);
  EXPECT_LE(stored_samples(), 15'100U) << "one fault, however long it lasts";
  live(seconds(1));
  live(seconds(1), true);
  EXPECT_GT(stored_samples(), 15'100U) << "the next one";
  EXPECT_EQ(resends_, 0U);
}

TEST_F(IngestIdle, ASessionOfWhichNothingIsHeardForAnHourIsIdle) {
  options_.idle.session_silence = seconds(10);
  restart();
  ingest_->note_plan(session_of(kSession, "2026-03-01T10:00:00Z"));
  live(seconds(100));
  EXPECT_LE(stored_samples(), 10'100U);
  store::Message word = message_of("session/state", kSession, "goes on");
  word.session = kSession;
  ingest_->take(std::move(word), true);
  live(seconds(5));
  EXPECT_GE(stored_samples(), 14'900U);
}

TEST_F(IngestIdle, AfterACrashTheRigIsAskedForWhatIsNotKnownToHaveBeenLetGoAndNoMore) {
  live(seconds(200));
  const std::uint64_t receipted = received_;
  ASSERT_GT(receipted, 100'000U);
  restart();
  std::vector<ResendRequest> requests;
  for (int i = 0; i < 20; ++i) {
    hear_rig(next_, received_);
    const auto resends = step_after(milliseconds(50)).resends;
    requests.insert(requests.end(), resends.begin(), resends.end());
  }
  ASSERT_FALSE(requests.empty());
  EXPECT_GE(requests[0].range.first, receipted);
  take_samples(requests[0].range.first, next_, kNoId, true);
  live(seconds(100));
  EXPECT_EQ(stored_samples(), 0U);
  EXPECT_GT(received_, next_ - 75'000);
  EXPECT_EQ(resends_, 0U);
}

TEST_F(IngestIdle, TheRingIsBounded) {
  options_.idle.ring_bytes = 10'000;
  restart();
  live(seconds(59));
  EXPECT_GT(received_, next_ / 2) << "let go before its minute is over";
  EXPECT_EQ(stored_samples(), 0U);
}

}  // namespace
}  // namespace tonus::archive
