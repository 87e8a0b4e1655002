#include "services/contract/names.hpp"

#include <gmock/gmock.h>
#include <set>
#include <string>

namespace tonus::v1 {
namespace {

TEST(Names, EveryPhaseAndEndHasANameOfItsOwn) {
  std::set<std::string> phases;
  for (unsigned phase = SESSION_PREPARING; phase <= SESSION_FAILED; ++phase)
    phases.insert(phase_name(static_cast<SessionPhase>(phase)));
  EXPECT_EQ(phases.size(), static_cast<std::size_t>(SESSION_FAILED) + 1);
  EXPECT_EQ(phases.count("unknown"), 0U);

  std::set<std::string> ends;
  for (unsigned end = TRIAL_COMPLETED; end <= TRIAL_BROKEN_OFF; ++end)
    ends.insert(end_name(static_cast<TrialEnd>(end)));
  EXPECT_EQ(ends.size(), static_cast<std::size_t>(TRIAL_BROKEN_OFF) + 1);
  EXPECT_EQ(ends.count("unknown end"), 0U);
}

TEST(Names, ASessionIsOverOnceItIsCompletedAbortedOrFailed) {
  for (unsigned phase = SESSION_PREPARING; phase <= SESSION_FAILED; ++phase) {
    const bool is_end = phase == SESSION_COMPLETED || phase == SESSION_ABORTED || phase == SESSION_FAILED;
    EXPECT_EQ(is_over(static_cast<SessionPhase>(phase)), is_end) << phase;
  }
}

}  // namespace
}  // namespace tonus::v1
