#include "services/dashboard/gateway/frames.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace tonus::dashboard {
namespace {

using ::testing::HasSubstr;

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> all;
  for (const int value : values) all.push_back(static_cast<std::byte>(value));
  return all;
}

TEST(Frames, MessageHeadIsOpcodeSubscriptionAndTimeInLittleEndian) {
  const std::string head = message_head(0x01020304, 0x1112131415161718);
  EXPECT_EQ(head, std::string("\x01\x04\x03\x02\x01\x18\x17\x16\x15\x14\x13\x12\x11", 13));
}

TEST(Frames, ServerInfoNamesCapabilitiesEncodingsAndMetadata) {
  const auto info = nlohmann::json::parse(server_info_text({"tonus", "abc", {{"role", "view"}}}));
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["capabilities"], nlohmann::json({"clientPublish"}));
  EXPECT_EQ(info["supportedEncodings"], nlohmann::json({"json"}));
  EXPECT_EQ(info["sessionId"], "abc");
  EXPECT_EQ(info["metadata"]["role"], "view");
}

TEST(Frames, AdvertiseHasEveryFieldOfEachChannel) {
  const auto text = advertise_text({{7, "rig/state", "cdr", "tonus::v1::RigState", "struct", "omgidl"}});
  EXPECT_EQ(nlohmann::json::parse(text), nlohmann::json::parse(R"({"op": "advertise", "channels": [
      {"id": 7, "topic": "rig/state", "encoding": "cdr", "schemaName": "tonus::v1::RigState",
       "schema": "struct", "schemaEncoding": "omgidl"}]})"));
}

TEST(Frames, StatusSurvivesBytesThatAreNoText) {
  EXPECT_TRUE(nlohmann::json::accept(status_text(StatusLevel::kError, "\xff\xfe")));
}

TEST(Frames, SubscribeAndUnsubscribeAreUnderstood) {
  const auto subscribe =
      parse_client_text(R"({"op": "subscribe", "subscriptions": [{"id": 0, "channelId": 3}]})");
  ASSERT_TRUE(subscribe);
  const auto& wanted = std::get<Subscribe>(*subscribe).subscriptions;
  ASSERT_EQ(wanted.size(), 1U);
  EXPECT_EQ(wanted[0].id, 0U);
  EXPECT_EQ(wanted[0].channel, 3U);
  const auto unsubscribe = parse_client_text(R"({"op": "unsubscribe", "subscriptionIds": [4, 5]})");
  ASSERT_TRUE(unsubscribe);
  EXPECT_EQ(std::get<Unsubscribe>(*unsubscribe).ids, (std::vector<std::uint32_t>{4, 5}));
}

TEST(Frames, ClientAdvertiseIsUnderstoodWithFieldsThatDoNotMatterHere) {
  const auto saying = parse_client_text(R"({"op": "advertise", "channels": [
      {"id": 1, "topic": "operator/request", "encoding": "json", "schemaName": "X"}]})");
  ASSERT_TRUE(saying);
  EXPECT_EQ(std::get<ClientAdvertise>(*saying).channels.at(0).topic, "operator/request");
}

class MalformedText : public ::testing::TestWithParam<const char*> {};

TEST_P(MalformedText, IsRefusedWithAReason) {
  const auto saying = parse_client_text(GetParam());
  ASSERT_FALSE(saying);
  EXPECT_EQ(saying.error().code, ErrorCode::kInvalidArgument);
  EXPECT_FALSE(saying.error().message.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Frames, MalformedText,
    ::testing::Values("", "{", "[]", "1", "null", R"({"op": 1})", R"({"op": "dance"})",
                      R"({"op": "subscribe"})", R"({"op": "subscribe", "subscriptions": [1]})",
                      R"({"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]})",
                      R"({"op": "subscribe", "subscriptions": [{"id": 1e300, "channelId": 1}]})",
                      R"({"op": "subscribe", "subscriptions": [{"id": 4294967296, "channelId": 1}]})",
                      R"({"op": "unsubscribe", "subscriptionIds": ["1"]})", R"({"op": "unadvertise"})",
                      R"({"op": "advertise", "channels": [{"id": 1, "topic": 2, "encoding": "json"}]})",
                      "{\"op\": \"\xff\"}"));

TEST(Frames, TooManyItemsInOneFrameAreRefused) {
  nlohmann::json frame{{"op", "unsubscribe"}, {"subscriptionIds", std::vector<int>(1025, 1)}};
  const auto saying = parse_client_text(frame.dump());
  ASSERT_FALSE(saying);
  EXPECT_THAT(saying.error().message, HasSubstr("1025"));
}

TEST(Frames, DeeplyNestedTextIsRefusedWithoutHarm) {
  EXPECT_FALSE(parse_client_text(std::string(200000, '[')));
}

TEST(Frames, ClientMessageIsChannelAndData) {
  const auto frame = bytes_of({1, 2, 0, 0, 1, 9, 8});
  const auto message = parse_client_binary(frame);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->channel, 0x01000002U);
  EXPECT_EQ(message->data.size(), 2U);
}

TEST(Frames, BinaryFramesOfOtherOpcodesOrTooShortAreRefused) {
  EXPECT_FALSE(parse_client_binary({}));
  EXPECT_FALSE(parse_client_binary(bytes_of({2, 0, 0, 0, 0, 0, 0, 0, 0})));
  EXPECT_FALSE(parse_client_binary(bytes_of({1, 0, 0, 0})));
}

}  // namespace
}  // namespace tonus::dashboard
