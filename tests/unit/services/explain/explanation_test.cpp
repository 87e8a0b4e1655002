#include "services/explain/explanation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>
#include <string>

namespace tonus::explain {
namespace {

using testing::HasSubstr;

TEST(Explanation, FindsAReasonInAnySpelling) {
  for (const char* spelling : {"off target", "off_target", "Off-Target", " OFF  target "}) {
    const auto found = find(spelling);
    ASSERT_TRUE(found) << spelling;
    EXPECT_EQ(found->front().text->name, "off target");
  }
}

TEST(Explanation, FindsAllKindsThatHaveTheName) {
  const auto found = find("bias not reached");
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), 2U);
  EXPECT_EQ((*found)[0].kind, Kind::kVerdict);
  EXPECT_EQ((*found)[1].kind, Kind::kTrialEnd);
}

TEST(Explanation, FindsTheFaultsOfAHoldsLine) {
  const auto found = find("fault: workspace, speed");
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), 3U);
  EXPECT_EQ((*found)[0].kind, Kind::kHold);
  EXPECT_EQ((*found)[1].text->name, "workspace");
  EXPECT_EQ((*found)[2].text->name, "speed");
}

TEST(Explanation, SuggestsTheNearestNameOfAMisspeltReason) {
  const auto found = find("of target");
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("did you mean off target?"));
}

TEST(Explanation, SaysHowToListTheReasonsWhereNoneIsNear) {
  for (const char* words : {"", "weather", ";;,"}) {
    const auto found = find(words);
    ASSERT_FALSE(found) << words;
    EXPECT_THAT(found.error().message, HasSubstr("tonus explain"));
  }
}

TEST(Explanation, BreaksLinesAtEightyColumns) {
  for (const Kind kind : kKinds) {
    for (const Explanation& one : explanations(kind)) {
      std::istringstream lines(as_text({kind, &one}));
      for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
    }
  }
}

TEST(Explanation, MakesAPageOfAllReasons) {
  const std::string page = reasons_page();
  for (const Kind kind : kKinds) {
    for (const Explanation& one : explanations(kind)) {
      EXPECT_THAT(page, HasSubstr("\n### " + std::string(one.name) + " {#"));
      EXPECT_THAT(page, HasSubstr(one.remedy));
    }
  }
}

}  // namespace
}  // namespace tonus::explain
