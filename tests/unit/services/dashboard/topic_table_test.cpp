#include "services/dashboard/gateway/topic_table.hpp"

#include <gmock/gmock.h>

#include "idl/topics.hpp"

namespace tonus::dashboard {
namespace {

using ::testing::HasSubstr;

const OfferedTopic& named(const std::vector<OfferedTopic>& all, std::string_view name) {
  return *std::find_if(all.begin(), all.end(), [&](const auto& t) { return t.channel.topic == name; });
}

TEST(TopicTable, OffersEveryTopicOfTheBusWithItsTypesText) {
  const auto all = offered_topics();
  ASSERT_EQ(all.size(), topics::kAll.size() + 4);
  for (std::size_t i = 0; i < topics::kAll.size(); ++i) {
    const auto& channel = all[i].channel;
    EXPECT_EQ(channel.topic, topics::kAll[i].name);
    EXPECT_EQ(channel.schema_name, topics::kAll[i].type_name);
    EXPECT_EQ(channel.schema_encoding, "omgidl");
    const auto type = channel.schema_name.substr(channel.schema_name.rfind(':') + 1);
    EXPECT_THAT(channel.schema, HasSubstr("struct " + type + " {")) << channel.topic;
  }
}

TEST(TopicTable, IdsAreTheTopicsPlaces) {
  const auto all = offered_topics();
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].channel.id, i + 1);
}

TEST(TopicTable, OnlyWhatIsForEyesMayBeThinned) {
  for (const auto& topic : offered_topics()) {
    const bool is_live = topic.flow == Flow::kLive;
    const auto& name = topic.channel.topic;
    EXPECT_EQ(is_live, name == "rig/samples" || name == "rig/auxiliary" || name == kHandTopic ||
                           name == "rig/lease" || name == "estimate/live" || name == "clock/probe" ||
                           name == "clock/echo" || name == kStatusTopic)
        << name;
  }
}

TEST(TopicTable, StateAndRepliesAreReadReliablyAndNoWriterOfTheRestWaitsForTheGateway) {
  const auto all = offered_topics();
  for (const char* name :
       {"session/state", "estimate/condition", "trial/verdict", "session/reply", "rig/reply"})
    EXPECT_TRUE(named(all, name).reading.qos.reliable) << name;
  for (const char* name :
       {"rig/samples", "rig/command", "trial/command", "session/command", "archive/resend"})
    EXPECT_FALSE(named(all, name).reading.qos.reliable) << name;
}

TEST(TopicTable, ATypeThatIsNotOfTheContractHasNoText) { EXPECT_EQ(schema_text("tonus::v1::Nothing"), ""); }

}  // namespace
}  // namespace tonus::dashboard
