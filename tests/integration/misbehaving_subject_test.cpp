#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "tests/integration/demo_run.hpp"

namespace tonus::testing {
namespace {

using Reasons = std::vector<v1::VerdictReason>;

/// What the archive says of the rejected attempts, and which planned trials counted.
struct Judged {
  std::map<std::uint32_t, Reasons> rejected;  // by attempt
  std::multiset<std::uint32_t> valid;         // planned_index
  std::map<std::uint32_t, std::uint32_t> planned_of_rejected;
};

Judged judged(const store::Session& session) {
  Judged found;
  for (const auto& trial : session.trials) {
    if (!trial.verdict) continue;
    const v1::TrialVerdict& verdict = trial.verdict->value;
    if (verdict.is_valid()) {
      found.valid.insert(verdict.planned_index());
    } else {
      found.rejected[verdict.attempt()] = verdict.reasons();
      found.planned_of_rejected[verdict.attempt()] = verdict.planned_index();
    }
  }
  return found;
}

void expect_session(const std::string& protocol, const std::string& profile_text, std::uint32_t planned,
                    const std::map<std::uint32_t, v1::VerdictReason>& misconduct) {
  TemporaryFolder folder;
  const auto profile = folder / "profile.toml";
  std::ofstream(profile) << profile_text;
  DemoRun run({source_file("deploy/protocols/" + protocol).string(), "--profile", profile.string()});
  ASSERT_EQ(run.finish(), 0) << run.everything_printed();
  const Judged found = judged(run.archived());

  for (const auto& [attempt, reason] : misconduct) {
    const auto rejected = found.rejected.find(attempt);
    ASSERT_NE(rejected, found.rejected.end()) << "attempt " << attempt << " counted";
    // A handle that was let go may also still swing at the end.
    const auto& reasons = rejected->second;
    EXPECT_EQ(std::count(reasons.begin(), reasons.end(), reason), 1) << "attempt " << attempt;
    const auto others = std::count_if(reasons.begin(), reasons.end(), [reason](auto other) {
      return other != reason && other != v1::REASON_NOT_AT_REST;
    });
    EXPECT_EQ(others, 0) << "attempt " << attempt;
    // It was run again, and then counted.
    EXPECT_EQ(found.valid.count(found.planned_of_rejected.at(attempt)), 1U) << "attempt " << attempt;
  }
  EXPECT_EQ(found.rejected.size(), misconduct.size()) << "others were rejected too";
  // Every planned trial counts once.
  EXPECT_EQ(found.valid.size(), planned);
  EXPECT_EQ(std::set<std::uint32_t>(found.valid.begin(), found.valid.end()).size(), planned);
}

TEST(MisbehavingSubject, IsRejectedInExactlyTheChosenTrialsForTheRightReason) {
  expect_session("unloaded.toml",
                 "[subject.misconduct]\n"
                 "is_on = true\n"
                 "pushes_early_in_trials = [3, 20, 60]\n"
                 "drifts_off_in_trials = [5, 33, 71]\n"
                 "lets_go_in_trials = [8, 41, 70]\n",
                 80,
                 {{3, v1::REASON_EARLY_REACTION},
                  {20, v1::REASON_EARLY_REACTION},
                  {60, v1::REASON_EARLY_REACTION},
                  {5, v1::REASON_OFF_TARGET},
                  {33, v1::REASON_OFF_TARGET},
                  {71, v1::REASON_OFF_TARGET},
                  {8, v1::REASON_LET_GO},
                  {41, v1::REASON_LET_GO},
                  {70, v1::REASON_LET_GO}});
}

TEST(MisbehavingSubject, IsRejectedUnderABiasToo) {
  expect_session("loaded.toml",
                 "[subject.recentring]\n"
                 "is_on = true\n"
                 "[subject.misconduct]\n"
                 "is_on = true\n"
                 "drifts_off_in_trials = [25, 140]\n"
                 "lets_go_in_trials = [30, 160, 250]\n",
                 288,
                 {{25, v1::REASON_OFF_TARGET},
                  {140, v1::REASON_OFF_TARGET},
                  {30, v1::REASON_LET_GO},
                  {160, v1::REASON_LET_GO},
                  {250, v1::REASON_LET_GO}});
}

}  // namespace
}  // namespace tonus::testing
