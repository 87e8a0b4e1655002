#include "tests/unit/services/archive/ingest_fixture.hpp"

#include <idl/session.h>

/// The certificate of a session that has ended.
namespace tonus::archive {
namespace {

using store::testing::kRig;
using store::testing::kSession;
using store::testing::session_of;
using store::testing::trial_of;

class IngestSession : public testing::IngestFixture {
 protected:
  void SetUp() override {
    IngestFixture::SetUp();
    ingest_->note_plan(session_of(kSession, "2026-03-01T10:00:00Z"));
    const Id first = trial_id(kSession, 1);
    take_samples(0, 80, first);
    take_samples(60, 80, first);         // 20 twice
    take_samples(80, 100, first, true);  // 20 sent again
    ingest_->note_outcome(trial_of(1, 0, 99));
    take_samples(100, 300, trial_id(kSession, 2));
    ingest_->note_outcome(trial_of(2, 100, 299));
    EXPECT_EQ(ingest_->step().trial_receipts.size(), 2U);
  }

  std::vector<store::SessionCertificate> end(v1::SessionPhase phase = v1::SESSION_COMPLETED) {
    ingest_->note_session_end(kSession, phase);
    return ingest_->step().session_receipts;
  }
};

TEST_F(IngestSession, IsCertifiedByTheSumsOverItsTrials) {
  const auto receipts = end();
  ASSERT_EQ(receipts.size(), 1U);
  EXPECT_EQ(receipts[0].session, kSession);
  EXPECT_EQ(receipts[0].rig, kRig);
  EXPECT_EQ(receipts[0].end, static_cast<std::uint32_t>(v1::SESSION_COMPLETED));
  EXPECT_EQ(receipts[0].trials, 2U);
  EXPECT_EQ(receipts[0].incomplete_trials, 0U);
  EXPECT_EQ(receipts[0].sums, (store::Certificate{300, 300, 20, 20, 0}));
  ASSERT_EQ(store_.session_certificates()->size(), 1U);
  EXPECT_EQ((*store_.session_certificates())[0].sums, receipts[0].sums);
}

TEST_F(IngestSession, IsNotCertifiedBeforeItsEndIsStored) {
  store_.is_failing = true;
  EXPECT_TRUE(end().empty());
  store_.is_failing = false;
  EXPECT_EQ(step_after(milliseconds(500)).session_receipts.size(), 1U);
}

TEST_F(IngestSession, IsCertifiedOnceForOneEnd) {
  EXPECT_EQ(end().size(), 1U);
  EXPECT_TRUE(end().empty());
  EXPECT_TRUE(step_after(std::chrono::seconds(5)).session_receipts.empty());
}

TEST_F(IngestSession, IsCertifiedAnewWhenATrialBecomesWholeLater) {
  take_samples(300, 380, trial_id(kSession, 3));
  ingest_->note_outcome(trial_of(3, 300, 399));
  const auto aborted = end(v1::SESSION_ABORTED);
  ASSERT_EQ(aborted.size(), 1U);
  EXPECT_EQ(aborted[0].trials, 3U);
  EXPECT_EQ(aborted[0].incomplete_trials, 1U);
  EXPECT_EQ(aborted[0].sums, (store::Certificate{400, 380, 20, 20, 20}));

  take_samples(380, 400, trial_id(kSession, 3), true);
  const auto whole = ingest_->step().session_receipts;
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_EQ(whole[0].incomplete_trials, 0U);
  EXPECT_EQ(whole[0].sums, (store::Certificate{400, 400, 40, 20, 0}));
  EXPECT_EQ((*store_.session_certificates())[0].sums.missing, 0U);
}

TEST_F(IngestSession, CountsTrialsOfAnArchiveThatDied) {
  restart();
  const auto receipts = end();
  ASSERT_EQ(receipts.size(), 1U);
  EXPECT_EQ(receipts[0].trials, 2U);
  EXPECT_EQ(receipts[0].sums, (store::Certificate{300, 300, 20, 20, 0}));
}

TEST_F(IngestSession, IsToldOnceMoreAfterARestart) {
  end();
  restart();
  const auto receipts = ingest_->step().session_receipts;
  ASSERT_EQ(receipts.size(), 1U);
  EXPECT_EQ(receipts[0].sums, (store::Certificate{300, 300, 20, 20, 0}));
  EXPECT_TRUE(end().empty());  // the scheduler's last word, heard again
}

TEST_F(IngestSession, WithoutAnyTrialHasSumsOfNothing) {
  const Id empty = id_of("empty session");
  ingest_->note_plan(session_of(empty, "2026-03-02T10:00:00Z"));
  ingest_->note_session_end(empty, v1::SESSION_ABORTED);
  const auto receipts = ingest_->step().session_receipts;
  ASSERT_EQ(receipts.size(), 1U);
  EXPECT_EQ(receipts[0].trials, 0U);
  EXPECT_EQ(receipts[0].rig, kRig);
  EXPECT_EQ(receipts[0].sums, store::Certificate{});
}

}  // namespace
}  // namespace tonus::archive
