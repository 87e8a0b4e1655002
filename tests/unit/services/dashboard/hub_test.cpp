#include "services/dashboard/gateway/hub.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

struct Link final : ClientLink {
  void wake() override { ++wakes; }
  void end(CloseCode code, const std::string& reason) override {
    ended = code;
    why = reason;
  }
  int wakes = 0;
  std::optional<CloseCode> ended;
  std::string why;
};

class HubTest : public ::testing::Test {
 protected:
  void build(Hub::Options options = {}) {
    hub_.emplace(offered_topics(), options, clock_,
                 [this](OperatorRequest r) { asked_.push_back(std::move(r)); });
  }
  HubTest() { build(); }

  std::uint32_t channel(std::string_view name) const {
    for (const auto& topic : hub_->topics())
      if (topic.channel.topic == name) return topic.channel.id;
    return 0;
  }

  PassedMessage message(std::string_view topic, std::uint8_t key, std::size_t bytes = 32) const {
    bus::Key k{};
    k[0] = key;
    return {channel(topic), k, 5, std::make_shared<const bus::Payload>(bytes, static_cast<std::byte>(key))};
  }

  ClientId join(Link& link, Role role = Role::kOperate) {
    const auto id = hub_->join(link, role, "peer");
    while (hub_->next(id)) {
    }
    return id;
  }

  void subscribe(ClientId id, std::uint32_t subscription, std::string_view topic) {
    hub_->on_text(id, json{{"op", "subscribe"},
                           {"subscriptions", {{{"id", subscription}, {"channelId", channel(topic)}}}}}
                          .dump());
  }

  void publish(ClientId id, const std::string& text) {
    hub_->on_text(id, R"({"op": "advertise", "channels": [{"id": 1, "topic": "operator/request",
                          "encoding": "json", "schemaName": ""}]})");
    const std::string frame = std::string("\x01\x01\0\0\0", 5) + text;
    hub_->on_binary(id, std::as_bytes(std::span(frame)));
  }

  std::vector<Outgoing> sent(ClientId id) {
    std::vector<Outgoing> all;
    while (auto next = hub_->next(id)) all.push_back(std::move(*next));
    return all;
  }

  ManualClock clock_;
  std::vector<OperatorRequest> asked_;
  std::optional<Hub> hub_;
};

std::string text_of(const bus::Payload& payload) {
  return {reinterpret_cast<const char*>(payload.data()), payload.size()};
}

TEST_F(HubTest, GreetsWithItsInfoTheRoleAndEveryChannel) {
  Link link;
  const auto id = hub_->join(link, Role::kView, "peer");
  const auto greeting = sent(id);
  ASSERT_THAT(greeting, SizeIs(2));
  EXPECT_TRUE(greeting[0].is_text);
  EXPECT_EQ(json::parse(greeting[0].head)["metadata"]["role"], "view");
  EXPECT_EQ(json::parse(greeting[1].head)["channels"].size(), hub_->topics().size());
}

TEST_F(HubTest, PassesAPayloadOnUntouchedAndShared) {
  Link link;
  const auto id = join(link);
  subscribe(id, 9, "rig/state");
  const auto given = message("rig/state", 1);
  hub_->on_bus_message(given);
  const auto got = sent(id);
  ASSERT_THAT(got, SizeIs(1));
  EXPECT_EQ(got[0].body, given.payload);
  EXPECT_EQ(got[0].head, message_head(9, 5));
  EXPECT_FALSE(got[0].is_text);
}

/// A message that can be read.
PassedMessage verdict_message(std::uint32_t channel, std::uint8_t key) {
  v1::TrialVerdict verdict;
  verdict.trial_id({key});
  bus::Key k{};
  k[0] = key;
  return {channel, k, 5, std::make_shared<const bus::Payload>(bus::encode(verdict).value())};
}

TEST_F(HubTest, MakesTheJsonOfAMessageOnceForAllWhoListen) {
  constexpr std::array<std::string_view, 1> kWanted{"trial/verdict"};
  Link first;
  Link second;
  const auto one = hub_->join_json(first, Role::kView, "peer", kWanted);
  const auto other = hub_->join_json(second, Role::kView, "peer", kWanted);
  hub_->on_bus_message(verdict_message(channel("trial/verdict"), 1));
  Link late;
  const auto third = hub_->join_json(late, Role::kView, "peer", kWanted);
  const auto got = sent(one);
  ASSERT_THAT(got, SizeIs(1));
  EXPECT_TRUE(got[0].is_text);
  EXPECT_EQ(json::parse(got[0].head + text_of(*got[0].body))["message"]["trial_id"],
            "01000000000000000000000000000000");
  EXPECT_EQ(sent(other).at(0).body, got[0].body);
  EXPECT_EQ(sent(third).at(0).body, got[0].body);
}

TEST_F(HubTest, AJsonClientThatIsTooSlowIsSentAwayRatherThanToldLess) {
  Hub::Options options;
  options.outbox.state_messages = 10;
  build(options);
  constexpr std::array<std::string_view, 1> kWanted{"trial/verdict"};
  Link slow;
  const auto id = hub_->join_json(slow, Role::kView, "peer", kWanted);
  for (std::uint8_t i = 0; i < 10; ++i) hub_->on_bus_message(verdict_message(channel("trial/verdict"), i));
  EXPECT_FALSE(slow.ended);
  hub_->on_bus_message(verdict_message(channel("trial/verdict"), 10));
  EXPECT_EQ(slow.ended, CloseCode::kTryAgain);
  EXPECT_THAT(slow.why, HasSubstr("too slow"));
  EXPECT_THAT(sent(id), IsEmpty());
}

TEST_F(HubTest, SendsNothingThatWasNotSubscribedOrIsNoMore) {
  Link link;
  const auto id = join(link);
  subscribe(id, 1, "rig/state");
  hub_->on_bus_message(message("session/state", 1));
  EXPECT_THAT(sent(id), IsEmpty());
  hub_->on_text(id, R"({"op": "unsubscribe", "subscriptionIds": [1]})");
  hub_->on_bus_message(message("rig/state", 1));
  EXPECT_THAT(sent(id), IsEmpty());
  EXPECT_FALSE(hub_->is_wanted(channel("rig/state")));
}

TEST_F(HubTest, WhoComesLateGetsTheNewestOfEachKeyOfKeptTopics) {
  hub_->on_bus_message(message("trial/verdict", 1));
  hub_->on_bus_message(message("trial/verdict", 2));
  hub_->on_bus_message(message("trial/verdict", 1));
  hub_->on_bus_message(message("trial/command", 1));
  Link link;
  const auto id = join(link);
  subscribe(id, 1, "trial/verdict");
  subscribe(id, 2, "trial/command");
  EXPECT_THAT(sent(id), SizeIs(2));
}

TEST_F(HubTest, ASlowClientGetsFewerLiveMessagesAndAllOfState) {
  Link link;
  const auto id = join(link);
  subscribe(id, 1, "rig/samples");
  subscribe(id, 2, "trial/verdict");
  for (int i = 0; i < 1000; ++i) {
    clock_.advance(std::chrono::milliseconds(10));
    hub_->on_bus_message(message("rig/samples", 1));
    hub_->on_bus_message(message("trial/verdict", static_cast<std::uint8_t>(i % 256)));
  }
  EXPECT_GT(hub_->thinned(), 0U);
  const auto got = sent(id);
  const auto verdicts =
      std::count_if(got.begin(), got.end(), [](const Outgoing& o) { return o.head[1] == 2; });
  EXPECT_EQ(verdicts, 1000);
  EXPECT_EQ(got.size() + hub_->thinned(), 2000U);
  EXPECT_FALSE(link.ended);
}

TEST_F(HubTest, AClientWhoseStateOverflowsIsSentAwayWithAReasonAndOthersGoOn) {
  Hub::Options options;
  options.outbox.state_messages = 10;
  build(options);
  Link slow;
  Link quick;
  const auto slow_id = join(slow);
  const auto quick_id = join(quick);
  subscribe(slow_id, 1, "rig/state");
  subscribe(quick_id, 1, "rig/state");
  for (int i = 0; i < 20; ++i) {
    hub_->on_bus_message(message("rig/state", 1));
    EXPECT_THAT(sent(quick_id), SizeIs(1));
  }
  ASSERT_TRUE(slow.ended);
  EXPECT_EQ(*slow.ended, CloseCode::kTryAgain);
  EXPECT_THAT(slow.why, HasSubstr("too slow"));
  EXPECT_THAT(sent(slow_id), IsEmpty()) << "its memory is free";
  EXPECT_FALSE(quick.ended);
  EXPECT_EQ(hub_->refused(Refused::kSlow), 1U);
}

TEST_F(HubTest, AFloodIsEndedAndOthersGoOn) {
  Link flood;
  Link other;
  const auto flood_id = join(flood);
  const auto other_id = join(other);
  for (int i = 0; i < 1000; ++i) hub_->on_text(flood_id, R"({"op": "unadvertise", "channelIds": []})");
  ASSERT_TRUE(flood.ended);
  EXPECT_EQ(*flood.ended, CloseCode::kPolicy);
  EXPECT_EQ(hub_->refused(Refused::kFlood), 1U);
  subscribe(other_id, 1, "rig/state");
  hub_->on_bus_message(message("rig/state", 1));
  EXPECT_THAT(sent(other_id), SizeIs(1));
}

TEST_F(HubTest, AMalformedMessageIsAnsweredAndManyEndTheConnection) {
  Link link;
  const auto id = join(link);
  hub_->on_text(id, "nonsense");
  const auto answer = sent(id);
  ASSERT_THAT(answer, SizeIs(1));
  EXPECT_EQ(json::parse(answer[0].head)["level"], 2);
  EXPECT_FALSE(link.ended);
  for (int i = 0; i < 10; ++i) hub_->on_text(id, "nonsense");
  EXPECT_EQ(link.ended, CloseCode::kPolicy);
  EXPECT_GE(hub_->refused(Refused::kMalformed), 9U);
}

TEST_F(HubTest, AClientThatErrsNowAndThenStays) {
  Link link;
  const auto id = join(link);
  for (int i = 0; i < 100; ++i) {
    hub_->on_text(id, "nonsense");
    clock_.advance(std::chrono::minutes(1));
  }
  EXPECT_FALSE(link.ended);
  EXPECT_THAT(sent(id), SizeIs(100));
}

TEST_F(HubTest, UnknownChannelsAndDoubledSubscriptionsAreRefused) {
  Link link;
  const auto id = join(link);
  hub_->on_text(id, R"({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 9999}]})");
  EXPECT_THAT(sent(id).at(0).head, HasSubstr("9999"));
  subscribe(id, 1, "rig/state");
  subscribe(id, 1, "rig/state");
  EXPECT_THAT(sent(id).at(0).head, HasSubstr("already"));
}

TEST_F(HubTest, TakesRequestsFromItsRequestTopicOnly) {
  Link link;
  const auto id = join(link);
  hub_->on_text(id,
                R"({"op": "advertise", "channels": [{"id": 1, "topic": "rig/command", "encoding": "cdr"}]})");
  EXPECT_THAT(sent(id), IsEmpty());
  std::string frame("\x01\x01\0\0\0{}", 7);
  hub_->on_binary(id, std::as_bytes(std::span(frame)));
  EXPECT_THAT(sent(id).at(0).head, HasSubstr("'rig/command' in cdr is not taken"));
  frame[1] = 2;
  hub_->on_binary(id, std::as_bytes(std::span(frame)));
  EXPECT_THAT(sent(id).at(0).head, HasSubstr("advertised"));
  EXPECT_THAT(asked_, IsEmpty());
}

TEST_F(HubTest, ADashboardMayAnnounceTopicsOfItsOwnAgainAndAgain) {
  Link link;
  const auto id = join(link);
  for (int i = 0; i < 24; ++i) {
    hub_->on_text(id, R"({"op": "advertise", "channels": [{"id": 7, "topic": "/clicked_point",
                          "encoding": "json"}]})");
    hub_->on_text(id, R"({"op": "unadvertise", "channelIds": [7]})");
  }
  EXPECT_THAT(sent(id), IsEmpty());
  EXPECT_FALSE(link.ended);
}

TEST_F(HubTest, HandsOnAnOperatorsRequestAndItsReply) {
  Link link;
  const auto id = join(link);
  subscribe(id, 4, kReplyTopic);
  publish(id, R"({"request_id": "000102030405060708090a0b0c0d0e0f", "request": "pause"})");
  ASSERT_THAT(asked_, SizeIs(1));
  EXPECT_EQ(asked_[0].requested_by, "dashboard peer");
  hub_->on_reply({asked_[0].id, "pause", true, "paused", "dashboard peer"});
  const auto got = sent(id);
  ASSERT_THAT(got, SizeIs(1));
  EXPECT_EQ(json::parse(text_of(*got[0].body))["message"], "paused");
}

TEST_F(HubTest, AViewersRequestIsRefusedWithAnAnswerButAnEmergencyStopGoesThrough) {
  Link link;
  const auto id = join(link, Role::kView);
  subscribe(id, 4, kReplyTopic);
  publish(id, R"({"request_id": "000102030405060708090a0b0c0d0e0f", "request": "abort"})");
  EXPECT_THAT(asked_, IsEmpty());
  const auto got = sent(id);
  ASSERT_THAT(got, SizeIs(1));
  EXPECT_EQ(json::parse(text_of(*got[0].body))["is_done"], false);
  EXPECT_EQ(hub_->refused(Refused::kForbidden), 1U);
  publish(id, R"({"request_id": "000102030405060708090a0b0c0d0e10", "request": "emergency_stop"})");
  EXPECT_THAT(asked_, SizeIs(1));
}

TEST_F(HubTest, SaysHowItIsToWhoSubscribes) {
  Link link;
  const auto id = join(link);
  hub_->publish_status(3);
  EXPECT_THAT(sent(id), IsEmpty());
  subscribe(id, 1, kStatusTopic);
  hub_->publish_status(3);
  const auto status = json::parse(text_of(*sent(id).at(0).body));
  EXPECT_EQ(status["arrival_drops"], 3);
  EXPECT_EQ(status["clients"].size(), 1U);
  EXPECT_EQ(status["clients"][0]["role"], "operate");
}

TEST_F(HubTest, WhoHasLeftIsForgottenButNotWhatWasThinned) {
  Link link;
  const auto id = join(link);
  subscribe(id, 1, "rig/samples");
  for (int i = 0; i < 1000; ++i) hub_->on_bus_message(message("rig/samples", 1));
  const auto thinned = hub_->thinned();
  EXPECT_GT(thinned, 0U);
  hub_->leave(id);
  EXPECT_EQ(hub_->clients(), 0U);
  EXPECT_EQ(hub_->thinned(), thinned);
  EXPECT_FALSE(hub_->is_wanted(channel("rig/samples")));
  hub_->on_bus_message(message("rig/samples", 1));
  EXPECT_FALSE(hub_->next(id));
}

}  // namespace
}  // namespace tonus::dashboard
