// SIGKILL of the rig agent in the middle of a trial, whole system, real time.
#include <csignal>
#include <gtest/gtest.h>
#include <set>

#include "tests/fault/rig/live_system.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{120};
constexpr int kDirections = 4;

TEST(AgentKilledInMidTrial, ItsSpooledSamplesAreArchivedAndTheTrialIsBrokenOffAndRepeated) {
  LiveSystem system;
  system.start_session(kDirections);
  ASSERT_TRUE(system.wait_for_mid_trial(100, kLimit)) << system.everything_printed();
  const std::uint64_t epoch = system.state()->epoch();
  const std::uint64_t sampled = system.state()->next_sequence();
  const Id trial = system.state()->trial_id();
  ASSERT_EQ(kill(system.service("tonus-rig-agent"), SIGKILL), 0);
  ASSERT_EQ(system.finish_session(kLimit), 0) << system.everything_printed();

  const store::Session session = system.archived();
  std::set<std::uint32_t> counted;
  const store::SessionTrial* broken = nullptr;
  for (const auto& t : session.trials) {
    if (t.verdict && t.verdict->value.is_valid()) counted.insert(t.verdict->value.planned_index());
    if (t.outcome && t.outcome->value.end() == v1::TRIAL_BROKEN_OFF) {
      EXPECT_EQ(broken, nullptr) << "more than one";
      broken = &t;
    }
  }
  ASSERT_NE(broken, nullptr) << system.everything_printed();
  EXPECT_EQ(broken->trial, trial);
  EXPECT_EQ(counted.size(), static_cast<std::size_t>(kDirections));
  EXPECT_EQ(counted.count(broken->outcome->value.program().planned_index()), 1U) << "it was not repeated";

  // What the rig had said it had sampled is there, up to the block that was still open.
  const v1::TrialOutcome& outcome = broken->outcome->value;
  EXPECT_EQ(outcome.epoch(), epoch);
  EXPECT_GE(outcome.last_sequence() + 100, sampled);
  ASSERT_TRUE(broken->record);
  EXPECT_TRUE(broken->record->is_certified);
  EXPECT_EQ(broken->record->certificate.missing, 0U);
  EXPECT_EQ(broken->record->certificate.received, outcome.last_sequence() - outcome.first_sequence() + 1);
  EXPECT_EQ(missing_samples(system.store_file()), "");
}

}  // namespace
}  // namespace tonus::testing
