#include <gtest/gtest.h>
#include <set>
#include <string>

#include "analysis_service/identification/trial_judge.hpp"
#include "analysis_service/impedance/identification.hpp"
#include "rig_agent/agent/hold_reason.hpp"
#include "rig_agent/control/fault.hpp"
#include "services/contract/names.hpp"
#include "services/explain/explanation.hpp"

namespace tonus::explain {
namespace {

using Names = std::set<std::string>;

Names explained(Kind kind) {
  Names names;
  for (const Explanation& one : explanations(kind)) names.emplace(one.name);
  return names;
}

/// The names of all values of an enumeration whose name_of() covers every enumerator (-Wswitch holds that).
template <typename Enum, typename NameOf>
Names names_of(NameOf name_of) {
  Names names;
  for (unsigned value = 0; value < 256; ++value) {
    const std::string name{name_of(static_cast<Enum>(value))};
    if (!name.starts_with("unknown") || name == "unknown rig") names.insert(name);
  }
  return names;
}

void expect_same(const Names& texts, const Names& code, const char* what) {
  EXPECT_FALSE(code.empty());
  for (const auto& name : code) {
    EXPECT_TRUE(texts.contains(name))
        << what << " '" << name << "' has no text: add it to services/explain, in the file of its kind";
  }
  for (const auto& name : texts)
    EXPECT_TRUE(code.contains(name)) << what << " '" << name << "' is explained, and no code gives it";
}

TEST(ReasonTexts, ExplainEveryReasonOfAVerdictAndNoOther) {
  expect_same(explained(Kind::kVerdict), names_of<v1::VerdictReason>(v1::reason_name), "verdict");
  const Names texts = explained(Kind::kVerdict);
  for (const auto& name :
       names_of<identification::Defect>([](auto defect) { return identification::name_of(defect); }))
    EXPECT_TRUE(texts.contains(name)) << "defect '" << name << "' has no text";
}

TEST(ReasonTexts, ExplainEveryReasonOfAnEstimateAndNoOther) {
  expect_same(explained(Kind::kEstimate),
              names_of<impedance::Reason>([](auto reason) { return impedance::name_of(reason); }),
              "estimate");
}

TEST(ReasonTexts, ExplainEveryFaultAndNoOther) {
  Names code;
  for (const auto fault : control::kAllFaults) code.insert(control::fault_name(fault));
  expect_same(explained(Kind::kFault), code, "fault");
}

TEST(ReasonTexts, ExplainEveryReasonOfAHoldAndNoOther) {
  Names code;
  for (const auto reason : rig::kHoldReasons) code.insert(rig::name_of(reason));
  expect_same(explained(Kind::kHold), code, "hold");
  expect_same(explained(Kind::kHold),
              names_of<rig::HoldReason>([](auto reason) { return rig::name_of(reason); }), "hold");
}

TEST(ReasonTexts, KnowTheLinesOfAllHolds) {
  for (const auto reason : rig::kHoldReasons) {
    const auto found = find("the rig is held: " + std::string(rig::phrase_of(reason)));
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->front().text->name, rig::name_of(reason));
  }
}

TEST(ReasonTexts, ExplainEveryEndOfATrialAndNoOther) {
  expect_same(explained(Kind::kTrialEnd), names_of<v1::TrialEnd>(v1::end_name), "trial end");
}

TEST(ReasonTexts, SayMeaningCausesAndRemedyInWholeSentences) {
  for (const Kind kind : kKinds) {
    for (const Explanation& one : explanations(kind)) {
      for (const auto text : {one.meaning, one.causes, one.remedy}) {
        EXPECT_TRUE(text.ends_with('.')) << one.name;
        EXPECT_GT(text.size(), 7U) << one.name;
      }
    }
  }
}

}  // namespace
}  // namespace tonus::explain
