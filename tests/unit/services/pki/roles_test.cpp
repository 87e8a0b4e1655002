#include "services/pki/roles.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <set>

#include "idl/topics.hpp"
#include "services/pki/documents.hpp"

namespace tonus::pki {
namespace {

bool may_write(std::string_view identity, std::string_view topic) {
  const auto found = find_identity(identity);
  return std::find(found->writes.begin(), found->writes.end(), topic) != found->writes.end();
}

TEST(Roles, EveryTopicHasAWriterAndNoIdentityWritesWhatIsNoTopic) {
  std::set<std::string_view> written;
  for (const Identity& identity : identities())
    written.insert(identity.writes.begin(), identity.writes.end());
  std::set<std::string_view> known;
  for (const auto& topic : topics::kAll) known.insert(topic.name);
  EXPECT_EQ(written, known);
}

TEST(Roles, IdentificationAndArchiveCannotCommandARig) {
  for (const char* identity : {"identification", "archive", "rig", "viewer", "subject"}) {
    for (const char* topic : {"rig/command", "trial/command", "rig/lease", "session/command", "session/plan"})
      EXPECT_FALSE(may_write(identity, topic)) << identity << " " << topic;
  }
  EXPECT_TRUE(may_write("scheduler", "rig/command"));
  EXPECT_TRUE(may_write("operator", "rig/command"));
}

TEST(Roles, OnlyTheRigSpeaksOfItsStateAndSamples) {
  for (const Identity& identity : identities()) {
    for (const char* topic : {"rig/state", "rig/samples", "rig/description", "trial/outcome", "rig/stopped"})
      EXPECT_EQ(may_write(identity.name, topic), identity.name == "rig") << identity.name << " " << topic;
  }
}

TEST(Roles, AViewerReadsEverythingAndWritesNothingButTheStop) {
  const auto viewer = find_identity("viewer");
  ASSERT_EQ(viewer->writes.size(), 1U);
  EXPECT_EQ(viewer->writes[0], "rig/stop");
  EXPECT_EQ(viewer->reads[0], "*");
}

TEST(Roles, ServicesAreThreeIdentitiesAndOthersOne) {
  EXPECT_EQ(identities_of_role("services")->size(), 3U);
  for (const char* role : {"rig", "dashboard", "operator", "viewer", "subject"}) {
    const auto given = identities_of_role(role);
    ASSERT_TRUE(given) << role;
    ASSERT_EQ(given->size(), 1U);
    EXPECT_EQ(given->front().name, role);
  }
  for (const char* role : {"scheduler", "", "Rig", "viewer "}) {
    const auto given = identities_of_role(role);
    ASSERT_FALSE(given) << role;
    EXPECT_NE(given.error().message.find("expected rig, services, dashboard"), std::string::npos);
  }
}

TEST(Documents, PermissionsNameWhatIsAllowedAndDenyTheRest) {
  using namespace std::chrono;
  const sys_seconds begin = sys_days{2026y / 3 / 1};
  const auto text = permissions_document(
      {"viewer@desk", *find_identity("viewer"), {"left", "right"}, begin, begin + days(30) + hours(1)});
  for (const char* part :
       {"<subject_name>CN=viewer@desk</subject_name>", "<not_before>2026-03-01T00:00:00Z</not_before>",
        "<not_after>2026-03-31T01:00:00Z</not_after>", "<publish><topics><topic>rig/stop</topic></topics>",
        "<subscribe><topics><topic>*</topic></topics>",
        "<partitions><partition>left</partition><partition>right</partition></partitions>",
        "<default>DENY</default>"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
}

}  // namespace
}  // namespace tonus::pki
