#include "services/contract/names.hpp"

#include <fstream>
#include <gmock/gmock.h>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace tonus::v1 {
namespace {

TEST(Names, EveryPhaseEndReasonAndStatusHasANameOfItsOwn) {
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

  std::set<std::string> reasons;
  for (unsigned reason = REASON_NOT_COMPLETED; reason <= REASON_REJECTED_BY_HAND; ++reason)
    reasons.insert(reason_name(static_cast<VerdictReason>(reason)));
  EXPECT_EQ(reasons.size(), static_cast<std::size_t>(REASON_REJECTED_BY_HAND) + 1);
  EXPECT_EQ(reasons.count("unknown reason"), 0U);

  std::set<std::string> states;
  for (unsigned status = ESTIMATE_OK; status <= ESTIMATE_SUSPECT; ++status)
    states.insert(status_name(static_cast<EstimateStatus>(status)));
  EXPECT_EQ(states.size(), static_cast<std::size_t>(ESTIMATE_SUSPECT) + 1);
  EXPECT_EQ(states.count("unknown"), 0U);

  std::set<std::string> tests;
  for (unsigned test = FIT_EXPLAINED_SHARE; test <= FIT_WIDTH; ++test)
    tests.insert(test_name(static_cast<FitTest>(test)));
  EXPECT_EQ(tests.size(), static_cast<std::size_t>(FIT_WIDTH) + 1);
  EXPECT_EQ(tests.count("unknown"), 0U);
}

/// The names that names.ts gives the constants that begin with `prefix`, in the order of their numbers.
std::vector<std::string> names_in_pages(const std::string& prefix) {
  std::ifstream file(std::string(TONUS_SOURCE_DIR) + "/services/dashboard/web/src/names.ts");
  const std::regex entry(R"re(\[\w+\.)re" + prefix + R"re(\w+\]: "([^"]*)")re");
  std::vector<std::string> names;
  std::smatch found;
  for (std::string line; std::getline(file, line);) {
    if (std::regex_search(line, found, entry)) names.push_back(found[1]);
  }
  return names;
}

TEST(Names, ThePagesSayTheSame) {
  using ::testing::ElementsAreArray;
  std::vector<std::string> phases;
  for (unsigned phase = SESSION_PREPARING; phase <= SESSION_FAILED; ++phase)
    phases.emplace_back(phase_name(static_cast<SessionPhase>(phase)));
  EXPECT_THAT(names_in_pages("SESSION_"), ElementsAreArray(phases));
  std::vector<std::string> ends;
  for (unsigned end = TRIAL_COMPLETED; end <= TRIAL_BROKEN_OFF; ++end)
    ends.emplace_back(end_name(static_cast<TrialEnd>(end)));
  EXPECT_THAT(names_in_pages("TRIAL_"), ElementsAreArray(ends));
  std::vector<std::string> states;
  for (unsigned status = ESTIMATE_OK; status <= ESTIMATE_SUSPECT; ++status)
    states.emplace_back(status_name(static_cast<EstimateStatus>(status)));
  EXPECT_THAT(names_in_pages("ESTIMATE_"), ElementsAreArray(states));
}

TEST(Names, ASessionIsOverOnceItIsCompletedAbortedOrFailed) {
  for (unsigned phase = SESSION_PREPARING; phase <= SESSION_FAILED; ++phase) {
    const bool is_end = phase == SESSION_COMPLETED || phase == SESSION_ABORTED || phase == SESSION_FAILED;
    EXPECT_EQ(is_over(static_cast<SessionPhase>(phase)), is_end) << phase;
  }
}

}  // namespace
}  // namespace tonus::v1
