#include "services/dashboard/gateway/people_api.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "services/contract/subject.hpp"
#include "tests/support/process.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;

store::SessionSummary session(std::uint8_t number, const std::string& subject, const std::string& protocol,
                              v1::SessionPhase phase, bool is_pilot = false,
                              const std::string& study = "cohort") {
  store::SessionSummary summary;
  summary.record.session = {number};
  summary.record.subject = subject;
  summary.record.protocol_name = protocol;
  summary.record.started_at = "2026-03-0" + std::to_string(number) + "T11:00:00Z";
  summary.plan.session_id({number});
  summary.plan.subject(subject);
  summary.plan.protocol_name(protocol);
  summary.plan.started_at(summary.record.started_at);
  summary.plan.study(study);
  summary.plan.is_pilot(is_pilot);
  summary.plan.subject_facts(contract::unknown_subject());
  v1::SessionState state;
  state.phase(phase);
  state.counted(80);
  state.planned(80);
  summary.state = state;
  return summary;
}

/// The shipped study: eleven subjects, three of them with a loaded session too.
json study(const std::vector<store::SessionSummary>& sessions) {
  return json::parse(studies_json(sessions, testing::source_file("deploy/protocols"))).at(0);
}

TEST(PeopleApi, WithoutSessionsTheFirstSubjectIsNext) {
  const json found = study({});
  EXPECT_EQ(found["study"], "cohort");
  EXPECT_EQ(found["subjects"].size(), 11U);
  EXPECT_EQ(found["subjects"][3]["sessions"].size(), 2U);
  EXPECT_EQ(found["next"],
            (json{{"subject", "s01"}, {"protocol", "unloaded"}, {"file", "unloaded"}, {"seed", 1}}));
}

TEST(PeopleApi, WhoHasBegunComesBeforeWhoHasNotAndAPilotCountsForNothing) {
  const json found = study({session(1, "s01", "unloaded", v1::SESSION_COMPLETED, true),
                            session(2, "s02", "unloaded", v1::SESSION_ABORTED),
                            session(3, "s04", "unloaded", v1::SESSION_COMPLETED)});
  EXPECT_EQ(found["next"],
            (json{{"subject", "s04"}, {"protocol", "loaded"}, {"file", "loaded"}, {"seed", 4}}));
  const json& subjects = found["subjects"];
  EXPECT_EQ(subjects[0]["due"], 1);
  EXPECT_EQ(subjects[0]["others"][0]["is_pilot"], true);
  EXPECT_EQ(subjects[1]["sessions"][0]["state"], "aborted");
  EXPECT_EQ(subjects[1]["sessions"][0]["is_done"], false);
  EXPECT_EQ(subjects[3]["done"], 1);
  EXPECT_EQ(subjects[3]["due"], 1);
  EXPECT_EQ(subjects[3]["sessions"][0]["is_done"], true);
  EXPECT_EQ(subjects[3]["sessions"][1]["session_id"], nullptr);
}

TEST(PeopleApi, ASessionThatWasRepeatedIsDoneOnce) {
  const json found = study({session(1, "s01", "unloaded", v1::SESSION_COMPLETED),
                            session(2, "s01", "unloaded", v1::SESSION_ABORTED)});
  EXPECT_EQ(found["subjects"][0]["done"], 1);
  EXPECT_EQ(found["subjects"][0]["sessions"][0]["is_done"], true);
  EXPECT_EQ(found["subjects"][0]["others"].size(), 1U);
  EXPECT_EQ(found["next"]["subject"], "s02");
}

TEST(PeopleApi, AStudyWithoutItsFileIsListedWithWhatIsDone) {
  const json all =
      json::parse(studies_json({session(1, "a", "short", v1::SESSION_COMPLETED, false, "elsewhere")},
                               testing::source_file("deploy/protocols")));
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[1]["study"], "elsewhere");
  EXPECT_EQ(all[1]["next"], nullptr);
  EXPECT_NE(all[1]["problem"], nullptr);
  EXPECT_EQ(all[1]["subjects"][0]["done"], 1);
  EXPECT_EQ(all[1]["subjects"][0]["due"], nullptr) << "not known is not zero";
}

TEST(PeopleApi, OfASubjectTheNewestFactsAndTheLastSessionAreGiven) {
  auto first = session(1, "sub-07", "unloaded", v1::SESSION_COMPLETED);
  auto second = session(2, "sub-07", "loaded", v1::SESSION_COMPLETED, true);
  first.plan.subject_facts().age_years(31.0);
  first.plan.subject_facts().weight_kg(60.0);
  second.plan.subject_facts().weight_kg(62.0);
  const json all = json::parse(subjects_json({first, second}));
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0]["subject"], "sub-07");
  EXPECT_EQ(all[0]["sessions"], 2);
  EXPECT_EQ(all[0]["pilot_sessions"], 1);
  EXPECT_EQ(all[0]["subject_facts"]["age_years"], 31.0);
  EXPECT_EQ(all[0]["subject_facts"]["weight_kg"], 62.0);
  EXPECT_EQ(all[0]["subject_facts"]["height_m"], nullptr);
  EXPECT_EQ(all[0]["last_started_at"], "2026-03-02T11:00:00Z");
}

}  // namespace
}  // namespace tonus::dashboard
