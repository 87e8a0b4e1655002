#include "rig_agent/agent/trial_log.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace tonus::rig {
namespace {

const Id kSession = id_of("session");

v1::TrialCommand command(std::uint32_t attempt, const Id& session = kSession) {
  v1::TrialCommand c;
  c.trial_id(trial_id(session, attempt));
  c.program().session_id(session);
  c.program().attempt(attempt);
  return c;
}

v1::TrialOutcome outcome(std::uint32_t attempt, const Id& session = kSession) {
  v1::TrialOutcome o;
  o.trial_id(trial_id(session, attempt));
  o.program(command(attempt, session).program());
  o.end(v1::TRIAL_COMPLETED);
  o.last_sequence(100 * attempt);
  return o;
}

TEST(TrialLog, KnowsWhatItWasToldAfterARestart) {
  const testing::TemporaryFolder folder;
  {
    auto log = TrialLog::open(folder / "log");
    ASSERT_TRUE(log && log->begun(command(1), 5, 10) && log->ended(outcome(1)) && log->received(5, 77));
  }
  auto log = TrialLog::open(folder / "log");
  ASSERT_TRUE(log);
  ASSERT_NE(log->find(trial_id(kSession, 1)), nullptr);
  EXPECT_EQ(log->find(trial_id(kSession, 1))->last_sequence(), 100U);
  EXPECT_EQ(log->find(trial_id(kSession, 2)), nullptr);
  EXPECT_FALSE(log->broken());
  EXPECT_EQ(log->received_through().at(5), 77U);
}

TEST(TrialLog, TellsOfATrialThatWasBegunAndNotEnded) {
  const testing::TemporaryFolder folder;
  {
    auto log = TrialLog::open(folder / "log");
    ASSERT_TRUE(log && log->begun(command(1), 5, 10) && log->ended(outcome(1)) &&
                log->begun(command(2), 5, 110));
  }
  for (int restart = 0; restart < 2; ++restart) {  // also when the next run dies before it has reported it
    auto log = TrialLog::open(folder / "log");
    ASSERT_TRUE(log && log->broken());
    EXPECT_EQ(log->broken()->command.program().attempt(), 2U);
    EXPECT_EQ(log->broken()->epoch, 5U);
    EXPECT_EQ(log->broken()->first_sequence, 110U);
  }
  auto log = TrialLog::open(folder / "log");
  ASSERT_TRUE(log->ended(outcome(2)));
  EXPECT_FALSE(log->broken());
}

TEST(TrialLog, ForgetsOtherSessionsWhenANewOneBegins) {
  const testing::TemporaryFolder folder;
  auto log = TrialLog::open(folder / "log");
  ASSERT_TRUE(log->begun(command(1), 5, 0) && log->ended(outcome(1)));
  const Id next = id_of("next session");
  ASSERT_TRUE(log->begun(command(1, next), 5, 200));
  EXPECT_EQ(log->find(trial_id(kSession, 1)), nullptr);
}

}  // namespace
}  // namespace tonus::rig
