// JSON over WebSocket and HTTP, on a real socket.

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/dashboard/gateway/json_messages.hpp"
#include "tests/unit/services/dashboard/gateway_fixture.hpp"

namespace tonus::dashboard::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

const std::string kViewToken = "view-token-0123456789";

Headers json_of(const std::string& query = "") { return {.target = "/json" + query, .subprotocol = ""}; }

template <typename T>
void put(Gateway& gateway, const bus::Topic<T>& topic, const T& value, bool is_live = false) {
  bus::Key key{};
  const auto payload = bus::encode(value).value();
  std::copy_n(payload.begin() + 4, key.size(), reinterpret_cast<std::byte*>(key.data()));
  gateway.inbox().put(
      {gateway.channel(topic.spec.name), key, 7, std::make_shared<const bus::Payload>(payload)}, is_live);
}

v1::TrialVerdict verdict(std::uint8_t id) {
  v1::TrialVerdict made;
  made.trial_id({id});
  made.is_valid(true);
  made.excursion_m(0.0125);
  return made;
}

TEST(JsonSocket, TellsTheNewestOfEachKeyAndThenWhatComes) {
  Gateway gateway;
  put(gateway, topics::kTrialVerdict, verdict(1));
  put(gateway, topics::kTrialVerdict, verdict(2));
  Client client(gateway.port());
  ASSERT_EQ(client.open(json_of("?topics=trial/verdict,session/state")), 101);
  const json first = json::parse(client.receive().value());
  EXPECT_EQ(first["topic"], "trial/verdict");
  EXPECT_EQ(first["time_ns"], 7);
  EXPECT_EQ(first["message"]["trial_id"], "01000000000000000000000000000000");
  EXPECT_EQ(first["message"]["excursion_m"], 0.0125);
  EXPECT_EQ(json::parse(client.receive().value())["message"]["trial_id"], "02000000000000000000000000000000");
  put(gateway, topics::kRigState, v1::RigState());  // not asked for
  v1::SessionState state;
  state.phase(v1::SESSION_RUNNING);
  put(gateway, topics::kSessionState, state);
  EXPECT_EQ(json::parse(client.receive().value())["message"]["phase"], "running");
}

TEST(JsonSocket, WithoutTopicsGivesAllOfThem) {
  Gateway gateway;
  Client client(gateway.port());
  ASSERT_EQ(client.open(json_of()), 101);
  put(gateway, topics::kSessionPlan, v1::SessionPlan());
  EXPECT_EQ(json::parse(client.receive().value())["topic"], "session/plan");
  put(gateway, topics::kEstimateLive, v1::Estimate(), true);  // not kept: for who is there by now
  EXPECT_EQ(json::parse(client.receive().value())["topic"], "estimate/live");
}

TEST(JsonSocket, ATopicThatDoesNotExistIsRefusedWithThoseThatDo) {
  Gateway gateway;
  for (const char* wrong : {"?topics=rig/samples", "?topics=trial/verdict,", "?topics=,",
                            "?topics=trial/verdict%00", "?topics=operator/reply", "?topics=TRIAL/VERDICT"}) {
    EXPECT_EQ(Client(gateway.port()).open(json_of(wrong)), 400) << wrong;
  }
  const auto refused = json_topics_of("rig/samples");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message,
              HasSubstr("'rig/samples' is not allowed; expected one or more of estimate/"));
}

TEST(JsonSocket, WantsATokenAndAnOriginAsEveryOtherWay) {
  Gateway gateway(Access({{kViewToken}, {}}, {}));
  EXPECT_EQ(Client(gateway.port()).open(json_of()), 401);
  EXPECT_EQ(Client(gateway.port()).open(json_of("?token=wrong-token-0123456789")), 401);
  EXPECT_EQ(Client(gateway.port()).open(json_of("?token=" + kViewToken)), 101);
  Headers foreign = json_of("?token=" + kViewToken);
  foreign.origin = "https://evil.example";
  EXPECT_EQ(Client(gateway.port()).open(foreign), 403);
  for (const char* path : {"/api/estimates", "/api/verdicts", "/api/outcomes", "/api/plans", "/api/states",
                           "/api/openapi.json", "/api/sessions/last/estimates"}) {
    EXPECT_EQ(get(gateway.port(), {.target = path}).first, 401) << path;
  }
}

TEST(JsonSocket, WhoSpeaksIsToldThatNothingIsTakenAndInTheEndHasToGo) {
  Gateway gateway;
  Client client(gateway.port());
  ASSERT_EQ(client.open(json_of("?topics=trial/verdict")), 101);
  client.send_text(
      R"({"op": "advertise", "channels": [{"id": 1, "topic": "operator/request", "encoding": "json"}]})");
  EXPECT_THAT(json::parse(client.receive().value())["error"], HasSubstr("takes no messages"));
  for (int i = 0; i < 12; ++i) client.send_text("x");
  while (client.receive()) {
  }
  EXPECT_EQ(client.close_code(), 1008);
  EXPECT_TRUE(gateway.asked().empty());
}

TEST(JsonSocket, AMessageThatCannotBeReadIsLeftOutAndCounted) {
  Gateway gateway;
  Client client(gateway.port());
  ASSERT_EQ(client.open(json_of("?topics=rig/state,trial/verdict")), 101);
  gateway.put("rig/state", 9);  // 32 bytes of nonsense
  put(gateway, topics::kTrialVerdict, verdict(3));
  EXPECT_EQ(json::parse(client.receive().value())["topic"], "trial/verdict");
  const json status = json::parse(get(gateway.port(), {.target = "/api/status"}).second);
  EXPECT_EQ(status["refused"]["malformed"], 1);
}

TEST(JsonHttp, GivesWhatIsInForceInTheSameForm) {
  Gateway gateway;
  v1::SessionState state;
  state.phase(v1::SESSION_PAUSED);
  put(gateway, topics::kSessionState, state);
  put(gateway, topics::kTrialVerdict, verdict(1));
  put(gateway, topics::kTrialVerdict, verdict(1));
  Client client(gateway.port());  // hears of the last one, so that all have arrived
  ASSERT_EQ(client.open(json_of("?topics=trial/verdict")), 101);
  ASSERT_TRUE(client.receive());
  const json verdicts = json::parse(get(gateway.port(), {.target = "/api/verdicts"}).second);
  ASSERT_EQ(verdicts.size(), 1U);
  EXPECT_EQ(verdicts[0]["message"]["is_valid"], true);
  const json states = json::parse(get(gateway.port(), {.target = "/api/states"}).second);
  ASSERT_EQ(states.size(), 1U);
  EXPECT_EQ(states[0]["message"]["phase"], "paused");
  EXPECT_EQ(get(gateway.port(), {.target = "/api/estimates"}).second, "[]");
}

TEST(JsonHttp, GivesAnArchivedSessionInTheSameForm) {
  ServerOptions options;
  options.folders.store = std::string(TONUS_SOURCE) + "/tests/acceptance/recorded_session/session.sqlite";
  Gateway gateway(Access({}, {}), options);
  const auto list = [&](const std::string& what) {
    return json::parse(get(gateway.port(), {.target = "/api/sessions/last/" + what}).second);
  };
  EXPECT_EQ(list("outcomes").size(), 8U);
  const json verdicts = list("verdicts");
  ASSERT_EQ(verdicts.size(), 8U);
  EXPECT_EQ(verdicts[0]["message"]["attempt"], 1);
  EXPECT_GT(verdicts[0]["time_ns"], 0);
  const json estimates = list("estimates");
  ASSERT_FALSE(estimates.empty());
  EXPECT_EQ(estimates[0]["message"]["posture"], "reference");
  EXPECT_EQ(list("plans")[0]["message"]["planned_trials"], 8);
  EXPECT_EQ(get(gateway.port(), {.target = "/api/sessions/ffff/estimates"}).first, 404);
  EXPECT_EQ(get(gateway.port(), {.target = "/api/sessions/last/samples"}).first, 404);
}

}  // namespace
}  // namespace tonus::dashboard::testing
