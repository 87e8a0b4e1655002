#include "services/core/id.hpp"

#include <gtest/gtest.h>
#include <set>

namespace tonus {
namespace {

TEST(Id, SurvivesTheWayThroughItsText) {
  const Id id = random_id();
  const auto back = id_from_hex(to_hex(id));
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, id);
}

TEST(Id, TakesHyphensAsUuidsHaveThem) {
  const auto id = id_from_hex("00112233-4455-6677-8899-aabbccddeeff");
  ASSERT_TRUE(id);
  EXPECT_EQ(to_hex(*id), "00112233445566778899aabbccddeeff");
}

TEST(Id, RefusesTextThatIsNone) {
  for (const char* text :
       {"", "12", "zz112233445566778899aabbccddeeff", "00112233445566778899aabbccddeeff00"}) {
    const auto id = id_from_hex(text);
    ASSERT_FALSE(id) << text;
    EXPECT_NE(id.error().message.find("32 hexadecimal digits"), std::string::npos);
  }
}

TEST(Id, OfTheSameTextIsTheSameAndOfOthersDifferent) {
  std::set<Id> ids;
  for (int i = 0; i < 10000; ++i) ids.insert(id_of("trial/" + std::to_string(i)));
  EXPECT_EQ(ids.size(), 10000U);
  EXPECT_EQ(id_of("rig/a"), id_of("rig/a"));
}

TEST(Id, OfATrialDependsOnSessionAndAttempt) {
  const Id session = random_id();
  EXPECT_EQ(trial_id(session, 3), trial_id(session, 3));
  EXPECT_NE(trial_id(session, 3), trial_id(session, 4));
  EXPECT_NE(trial_id(session, 3), trial_id(random_id(), 3));
}

}  // namespace
}  // namespace tonus
