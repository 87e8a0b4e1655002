#include "services/contract/subject.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace tonus::contract {
namespace {

std::string refusal(const v1::SubjectFacts& facts) {
  const auto checked = check_subject_facts(facts);
  return checked ? std::string() : checked.error().message;
}

TEST(Subject, OfWhomNothingIsKnownIsAllowed) {
  EXPECT_TRUE(check_subject_facts(unknown_subject()));
  EXPECT_FALSE(is_anything_known(unknown_subject()));
}

TEST(Subject, IsKnownByOneFact) {
  v1::SubjectFacts facts = unknown_subject();
  facts.shoulder_m({std::nan(""), 0.0});
  EXPECT_TRUE(is_anything_known(facts));
}

TEST(Subject, HasAnAgeOf89AtMostBecauseOlderPeopleAreKnownByTheirAge) {
  v1::SubjectFacts facts = unknown_subject();
  for (const double age : {0.0, 31.5, 89.0}) {
    facts.age_years(age);
    EXPECT_EQ(refusal(facts), "") << age;
  }
  facts.age_years(93.0);
  EXPECT_EQ(refusal(facts), "age: 93 is not allowed; expected 0 to 89 years; 89 stands for 89 and more");
  facts.age_years(-1.0);
  EXPECT_EQ(refusal(facts), "age: -1 is not allowed; expected 0 to 89 years; 89 stands for 89 and more");
  facts.age_years(INFINITY);
  EXPECT_NE(refusal(facts), "");
}

TEST(Subject, HasSexHandednessAndArmOfTheLists) {
  v1::SubjectFacts facts = unknown_subject();
  facts.sex("other");
  facts.handedness("ambidextrous");
  facts.measured_arm("left");
  EXPECT_EQ(refusal(facts), "");
  facts.sex("m");
  EXPECT_EQ(refusal(facts), "sex: 'm' is not allowed; expected male, female or other");
  facts.sex("male");
  facts.handedness("Right");
  EXPECT_EQ(refusal(facts), "handedness: 'Right' is not allowed; expected right, left or ambidextrous");
  facts.handedness("");
  facts.measured_arm("both");
  EXPECT_EQ(refusal(facts), "arm: 'both' is not allowed; expected right or left");
}

TEST(Subject, HasLengthsOfAPerson) {
  v1::SubjectFacts facts = unknown_subject();
  facts.link_lengths_m({0.31, 34.0});  // cm
  EXPECT_EQ(
      refusal(facts),
      "link-lengths: 34 is not allowed; expected 0.05 to 1 m for the upper arm and for the forearm with "
      "the hand");
  facts.link_lengths_m({0.31, 0.34});
  facts.circumferences_m({0.0, 0.25});
  EXPECT_EQ(refusal(facts),
            "circumferences: 0 is not allowed; expected 0.05 to 1 m for the upper arm and for the forearm");
  facts.circumferences_m({std::nan(""), 0.25});  // one of them is not known
  facts.height_m(178.0);
  EXPECT_EQ(refusal(facts), "height: 178 is not allowed; expected 0.3 to 2.6 m");
  facts.height_m(1.78);
  facts.weight_kg(0.0);
  EXPECT_EQ(refusal(facts), "weight: 0 is not allowed; expected 2 to 400 kg");
  facts.weight_kg(74.0);
  facts.shoulder_m({-0.2, 6.0});
  EXPECT_EQ(refusal(facts), "shoulder: 6 is not allowed; expected -5 to 5 m for x and for y");
}

TEST(SubjectName, IsAnyOneLineThatHasALabelInBids) {
  for (const char* name : {"s01", "sub-01", "P 01", "Jürgen"}) EXPECT_TRUE(check_subject_name(name)) << name;
  for (const std::string& name : {std::string(), std::string("sub-"), std::string("a\nb"),
                                  std::string("\x1b[2J"), std::string("\xff"), std::string(81, 's')})
    EXPECT_FALSE(check_subject_name(name)) << name;
  EXPECT_EQ(
      check_subject_name("sub-").error().message,
      "subject: 'sub-' is not allowed; expected a name of 1 to 80 bytes on one line, after 'sub-' if it "
      "begins so");
}

TEST(SubjectName, OfAnyLengthGivesAMessageOfOneLine) {
  const std::string message = check_subject_name(std::string(100'000, 'x')).error().message;
  EXPECT_LT(message.size(), 200U);
  EXPECT_NE(message.find("(100000 bytes)"), std::string::npos);
}

TEST(People, AreCheckedTogether) {
  v1::SessionCommand start;
  start.subject("s01");
  start.subject_facts(unknown_subject());
  EXPECT_TRUE(check_people(start));
  start.study("posture\n2026");
  EXPECT_EQ(check_people(start).error().message.substr(0, 6), "study:");
  start.study("posture 2026");
  start.requested_by(std::string(81, 'o'));
  EXPECT_EQ(check_people(start).error().message.substr(0, 9), "operator:");
}

TEST(SubjectFacts, KeepWhatANewerStatementDoesNotSay) {
  v1::SubjectFacts facts = unknown_subject();
  facts.age_years(30.0);
  facts.sex("female");
  facts.link_lengths_m({0.30, 0.33});
  v1::SubjectFacts newer = unknown_subject();
  newer.age_years(31.0);
  newer.link_lengths_m({std::nan(""), 0.34});
  update_facts(facts, newer);
  EXPECT_EQ(facts.age_years(), 31.0);
  EXPECT_EQ(facts.sex(), "female");
  EXPECT_EQ(facts.link_lengths_m(), (std::array{0.30, 0.34}));
}

}  // namespace
}  // namespace tonus::contract
