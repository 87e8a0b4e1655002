// Everybody but the rig stands still for a while: it goes on, and the archive has every sample afterwards.
#include "tests/fault/rig/stall.hpp"

#include <gtest/gtest.h>

#include "tests/support/bus/private_network.hpp"

namespace tonus::testing {
namespace {

constexpr unsigned kSeconds = 4;  // rig_stall_campaign --seconds 60 is the long form.

void expect_unharmed(Stall stall) {
  const auto report = run_stalled_session(stall, kSeconds);
  ASSERT_TRUE(report) << report.error().message;
  SCOPED_TRACE(text_of(*report));
  EXPECT_GE(report->stalled.cycles, 4000U - 1000U);  // The rig tells of its cycles once a second.
  EXPECT_EQ(report->dropped_samples, 0U);
  EXPECT_EQ(report->missing, "");
  EXPECT_EQ(report->faulted_trials, 0U);
  EXPECT_EQ(report->counted_trials, report->planned_trials);
}

TEST(Stall, OfEveryOtherServiceCostsNeitherTrialNorSample) { expect_unharmed(Stall::kServices); }

TEST(Stall, OfTheBusCostsNeitherTrialNorSample) {
  if (const auto entered = test::enter_private_network(); !entered) GTEST_SKIP() << entered.error().message;
  expect_unharmed(Stall::kBus);
}

}  // namespace
}  // namespace tonus::testing
