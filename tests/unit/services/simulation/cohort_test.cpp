#include "services/simulation/cohort.hpp"

#include <gtest/gtest.h>

namespace tonus::simulation {
namespace {

std::string refusal(const std::string& text) {
  const auto cohort = parse_cohort(text, "cohort.toml");
  return cohort ? "accepted" : cohort.error().message;
}

constexpr const char* kTwo = R"(
schema = 1
[common.subject.tremor]
is_on = true
[[subject]]
name = "a"
link_masses_kg = [2.0, 1.5]
joint_stiffness_Nm_per_rad = { shoulder = 20.0, elbow = 15.0, two_joint = 5.0 }
damping_time_s = { shoulder = 0.06, elbow = 0.04, two_joint = 0.02 }
[[subject]]
name = "b"
)";

TEST(Cohort, GivesEverySubjectWhatIsCommonAndWhatIsOwn) {
  const auto cohort = parse_cohort(kTwo, "cohort.toml");
  ASSERT_TRUE(cohort) << cohort.error().message;
  ASSERT_EQ(cohort->size(), 2U);
  EXPECT_TRUE((*cohort)[0].profile.subject.tremor.is_on);
  EXPECT_TRUE((*cohort)[1].profile.subject.tremor.is_on);
  EXPECT_EQ((*cohort)[0].profile.subject.link_masses, Eigen::Vector2d(2.0, 1.5));
  EXPECT_EQ((*cohort)[1].profile.subject.link_masses, Profile{}.subject.link_masses);
}

TEST(Cohort, MakesDampingOfTheTimeConstantsOfTheMatrixElements) {
  const auto cohort = parse_cohort(kTwo, "cohort.toml");
  ASSERT_TRUE(cohort) << cohort.error().message;
  const SubjectProfile& subject = cohort->front().profile.subject;
  const Eigen::Matrix2d K = subject.stiffness.matrix();
  const Eigen::Matrix2d B = subject.damping.matrix();
  EXPECT_NEAR(B(0, 0), 0.06 * K(0, 0), 1e-12);
  EXPECT_NEAR(B(1, 1), 0.04 * K(1, 1), 1e-12);
  EXPECT_NEAR(B(0, 1), 0.02 * K(0, 1), 1e-12);
}

TEST(Cohort, WritesEachSubjectAsAProfileThatSaysTheSame) {
  const auto cohort = parse_cohort(kTwo, "cohort.toml");
  ASSERT_TRUE(cohort) << cohort.error().message;
  const auto profile = parse_profile(cohort->front().profile_toml, "a.toml");
  ASSERT_TRUE(profile) << profile.error().message;
  EXPECT_EQ(profile->subject.damping.matrix(), cohort->front().profile.subject.damping.matrix());
  EXPECT_TRUE(profile->subject.tremor.is_on);
}

TEST(Cohort, ReadsTheElevenSubjectsOfTheStudy) {
  const auto cohort = load_cohort(TONUS_SOURCE_DIR "/deploy/profiles/cohort.toml");
  ASSERT_TRUE(cohort) << cohort.error().message;
  EXPECT_EQ(cohort->size(), 11U);
  for (const CohortSubject& subject : *cohort) {
    const SubjectProfile& s = subject.profile.subject;
    EXPECT_GT(s.damping.shoulder, 0.0) << subject.name;
    EXPECT_GT(s.damping.elbow, 0.0) << subject.name;
    EXPECT_TRUE(s.links.reaches({0.0, 0.52})) << subject.name;
    EXPECT_TRUE(s.links.reaches({-0.295, 0.38})) << subject.name;
  }
}

TEST(Cohort, RefusesWhatIsNoCohort) {
  EXPECT_EQ(refusal("schema = 1\n"),
            "cohort.toml: subject is missing; expected one table [[subject]] or more");
  EXPECT_EQ(refusal("[[subject]]\nlink_masses_kg = [2.0, 1.5]\n"),
            "cohort.toml: subject[1].name is missing; expected text of 1 to 40 characters");
  EXPECT_EQ(refusal("[[subject]]\nname = \"a\"\n[[subject]]\nname = \"a\"\n"),
            "cohort.toml: subject[2].name: \"a\" is not allowed; expected each name once");
  EXPECT_EQ(refusal("[[subject]]\nname = \"a\"\nlink_masses_kg = [2.0, -1.5]\n"),
            "cohort.toml, subject 'a': subject.link_masses_kg: [2, -1.5] is not allowed; expected [x, y], "
            "each 0.1 to 20");
}

}  // namespace
}  // namespace tonus::simulation
