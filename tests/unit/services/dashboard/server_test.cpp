#include "services/dashboard/gateway/server.hpp"

#include <fstream>
#include <spdlog/fmt/fmt.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sstream>
#include <thread>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/dashboard/gateway_fixture.hpp"

namespace tonus::dashboard::testing {
namespace {

using nlohmann::json;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kViewToken = "view-token-0123456789";
const std::string kOperateToken = "operate-token-0123456789";

Access with_tokens() { return Access({{kViewToken}, {kOperateToken}}, {}); }

/// That nobody else is affected: another client connects and gets a value.
void expect_in_order(Gateway& gateway) {
  Client other(gateway.port());
  ASSERT_EQ(other.open(), 101);
  EXPECT_EQ(other.receive_op("advertise")["op"], "advertise");
  gateway.put("rig/state", 77);
  other.subscribe(1, gateway.channel("rig/state"));
  const auto message = other.receive();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->size(), 13U + 32U);
}

TEST(Server, GreetsAndPassesABusMessageOnByteForByte) {
  Gateway gateway;
  Client client(gateway.port());
  ASSERT_EQ(client.open(), 101);
  EXPECT_EQ(client.receive_op("serverInfo")["metadata"]["role"], "operate");
  EXPECT_GT(client.receive_op("advertise")["channels"].size(), 20U);
  gateway.put("rig/state", 7);
  client.subscribe(3, gateway.channel("rig/state"));
  const auto message = client.receive();
  ASSERT_TRUE(message);
  EXPECT_EQ(*message, message_head(3, 1) + std::string(32, '\x07'));
}

TEST(Server, APortInUseIsOneClearLine) {
  Gateway first;
  ServerOptions options;
  options.listen.port = first.port();

  const SystemClock clock;
  Hub hub(offered_topics(), {}, clock, [](OperatorRequest) {});
  const auto second = Server::create(options, Access({}, {}), std::nullopt, hub, clock);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("127.0.0.1:" + std::to_string(first.port())));
  EXPECT_THAT(second.error().message, HasSubstr("in use"));
}

TEST(Server, WrongTokensForeignOriginsAndOtherSubprotocolsAreRefused) {
  Gateway gateway(with_tokens());
  const auto status = [&](const Headers& headers) { return Client(gateway.port()).open(headers); };
  EXPECT_EQ(status({}), 401);
  EXPECT_EQ(status({.target = "/?token=wrong-token-0123456789"}), 401);
  EXPECT_EQ(status({.target = "/?token=" + kViewToken, .origin = "https://evil.example"}), 403);
  EXPECT_EQ(status({.target = "/?token=" + kViewToken, .subprotocol = ""}), 400);
  EXPECT_EQ(status({.target = "/?token=" + kViewToken, .subprotocol = "chat"}), 400);
  EXPECT_EQ(status({.target = "/?token=" + kViewToken}), 101);
  EXPECT_EQ(status({.authorization = "Bearer " + kOperateToken,
                    .subprotocol = std::string("foxglove.sdk.v1, ") + kSubprotocol}),
            101);
}

TEST(Server, ArchiveAndReportsWantATokenAsTheWebSocketDoes) {
  Gateway gateway(with_tokens());
  for (const char* target : {"/api/sessions", "/api/protocols", "/api/status", "/reports/x.html", "/metrics"})
    EXPECT_EQ(get(gateway.port(), {.target = target}).first, 401) << target;
  EXPECT_EQ(get(gateway.port(), {.target = "/api/role", .authorization = "Bearer " + kViewToken}).second,
            R"({"role":"view"})");
  EXPECT_EQ(get(gateway.port(), {.target = "/api/gateway"}).first, 200);
}

TEST(Server, GivesMetricsInPrometheusTextFormat) {
  Gateway gateway(with_tokens());
  const std::string answer = answer_to(gateway.port(),
                                       "GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
                                       "Authorization: Bearer " +
                                           kViewToken + "\r\n\r\n");
  EXPECT_THAT(answer, HasSubstr("200 OK"));
  EXPECT_THAT(answer, HasSubstr("Content-Type: text/plain; version=0.0.4"));
  EXPECT_THAT(answer, HasSubstr("# TYPE tonus_gateway_clients gauge\ntonus_gateway_clients 0\n"));
}

TEST(Server, GivesAPageCompressedToWhoTakesItSoAndAsItIsToOthers) {
  const ::tonus::testing::TemporaryFolder folder;
  for (const auto& [name, text] : {std::pair{"index.html", "the whole text"}, {"index.html.gz", "small"}})
    std::ofstream(folder.path() / name) << text;
  auto pages = Pages::load(folder.path());
  ASSERT_TRUE(pages) << pages.error().message;
  Gateway gateway(Access({}, {}), {}, {}, std::move(*pages));
  const auto ask = [&](const std::string& path, const std::string& header) {
    return answer_to(gateway.port(), "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + header +
                                         "Connection: close\r\n\r\n");
  };
  const std::string compressed = ask("/", "Accept-Encoding: gzip, deflate, br\r\n");
  EXPECT_THAT(compressed, HasSubstr("Content-Encoding: gzip\r\n"));
  EXPECT_THAT(compressed, HasSubstr("Content-Type: text/html"));
  EXPECT_THAT(compressed, HasSubstr("Vary: Accept-Encoding\r\n"));
  EXPECT_THAT(compressed, EndsWith("\r\n\r\nsmall"));
  const std::string plain = ask("/", "");
  EXPECT_THAT(plain, Not(HasSubstr("Content-Encoding")));
  EXPECT_THAT(plain, HasSubstr("Vary: Accept-Encoding\r\n"));
  EXPECT_THAT(plain, EndsWith("\r\n\r\nthe whole text"));
  const std::string other = ask("/api/gateway", "Accept-Encoding: gzip\r\n");
  EXPECT_THAT(other, Not(HasSubstr("Content-Encoding"))) << "what is no page goes as it is";
}

TEST(Server, AReportsPicturesAreGivenToWhoHasOpenedTheReport) {
  Gateway gateway(with_tokens());
  const auto status = [&](const std::string& target, const std::string& cookie) {
    return get(gateway.port(), {.target = target, .cookie = "tonus-report=" + cookie}).first;
  };
  EXPECT_EQ(status("/reports/a.svg", kViewToken), 404) << "let in; there is no report";
  EXPECT_EQ(status("/reports/a.svg", "wrong"), 401);
  EXPECT_EQ(status("/api/sessions", kViewToken), 401) << "the cookie is for reports only";
}

TEST(Server, WithoutTokensAHostNameOfElsewhereIsRefused) {
  Gateway gateway;
  EXPECT_EQ(get(gateway.port(), {.target = "/api/sessions", .host = "evil.example"}).first, 403);
  EXPECT_EQ(Client(gateway.port()).open({.host = "evil.example"}), 403);
}

TEST(Server, AViewersEmergencyStopIsPassedOn) {
  Gateway gateway(with_tokens());
  Client client(gateway.port());
  ASSERT_EQ(client.open({.target = "/?token=" + kViewToken}), 101);
  client.send_text(R"({"op": "advertise", "channels": [
      {"id": 1, "topic": "operator/request", "encoding": "json", "schemaName": "x"}]})");
  client.subscribe(1, gateway.channel("operator/reply"));
  const std::string head("\x01\x01\0\0\0", 5);
  client.send_binary(head +
                     R"({"request_id": "000102030405060708090a0b0c0d0e0f", "request": "emergency_stop"})");
  client.send_binary(head + R"({"request_id": "000102030405060708090a0b0c0d0e10", "request": "abort"})");
  std::optional<std::string> answer;
  do {
    answer = client.receive();
    ASSERT_TRUE(answer);
  } while (answer->front() != '\x01');
  EXPECT_EQ(json::parse(answer->substr(13))["request"], "abort");  // the refusal; the stop was before it
  ASSERT_EQ(gateway.asked().size(), 1U);
  EXPECT_EQ(gateway.asked()[0].name, "emergency_stop");
}

TEST(Server, AnOversizedFrameEndsItsConnectionOnly) {
  ServerOptions options;
  options.maximum_frame_bytes = 1000;
  Gateway gateway(Access({}, {}), options);
  Client client(gateway.port());
  ASSERT_EQ(client.open(), 101);
  client.send_text(std::string(2000, 'x'));
  while (client.receive()) {
  }
  EXPECT_EQ(client.close_code(), 1009);
  expect_in_order(gateway);
}

TEST(Server, AFloodEndsItsConnectionOnly) {
  Gateway gateway;
  Client client(gateway.port());
  ASSERT_EQ(client.open(), 101);
  for (int i = 0; i < 400; ++i) client.send_text(R"({"op": "unadvertise", "channelIds": []})");
  while (client.receive()) {
  }
  EXPECT_EQ(client.close_code(), 1008);
  EXPECT_THAT(client.close_reason(), HasSubstr("a second"));
  expect_in_order(gateway);
}

TEST(Server, MalformedMessagesAreAnsweredAndManyEndTheirConnectionOnly) {
  Gateway gateway;
  Client client(gateway.port());
  ASSERT_EQ(client.open(), 101);
  client.send_text("nonsense");
  EXPECT_EQ(client.receive_op("status")["level"], 2);
  for (int i = 0; i < 10; ++i) client.send_text("nonsense");
  while (client.receive()) {
  }
  EXPECT_EQ(client.close_code(), 1008);
  expect_in_order(gateway);
}

TEST(Server, WhatIsNotHttpIsRefused) {
  Gateway gateway;
  EXPECT_THAT(answer_to(gateway.port(), "\x16\x03\x01 nonsense\r\n\r\n"), HasSubstr("400"));
  EXPECT_THAT(answer_to(gateway.port(), "GET / HTTP/1.1\r\nX: " + std::string(20000, 'x') + "\r\n\r\n"),
              HasSubstr("413"));
  EXPECT_THAT(answer_to(gateway.port(), "POST /api/sessions HTTP/1.0\r\nHost: localhost\r\n\r\n"),
              HasSubstr("405"));
  expect_in_order(gateway);
}

TEST(Server, AClientThatReadsNothingIsSentAwayAndNobodyWaitsForIt) {
  Hub::Options hub;
  hub.outbox.state_bytes = 1 << 20;
  Gateway gateway(Access({}, {}), {}, hub);
  Client slow(gateway.port());
  ASSERT_EQ(slow.open(), 101);
  slow.subscribe(1, gateway.channel("trial/outcome"));
  Client quick(gateway.port());
  ASSERT_EQ(quick.open(), 101);
  quick.subscribe(1, gateway.channel("trial/outcome"));
  std::size_t got = 0;
  constexpr std::size_t kMessages = 400;
  for (std::size_t i = 0; i < kMessages; ++i) {
    gateway.put("trial/outcome", static_cast<std::uint8_t>(i % 200), 60000);
    for (bool is_data = false; !is_data; ++got) {
      const auto message = quick.receive();
      ASSERT_TRUE(message) << got;
      is_data = message->size() == 60013;
      if (!is_data) --got;
    }
  }
  EXPECT_EQ(got, kMessages);
  const auto refused = json::parse(get(gateway.port(), {.target = "/api/status"}).second)["refused"];
  EXPECT_EQ(refused["slow"], 1);
}

/// What is logged while this is there.
class Log {
 public:
  Log() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_)));
  }
  ~Log() { spdlog::set_default_logger(before_); }
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;
  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

TEST(Server, ChecksAProtocolThatIsPosted) {
  Gateway gateway;
  const std::string text = "schema = 1\nkind = \"none\"\n";
  const auto post = [&](const std::string& target, const std::string& body) {
    return answer_to(gateway.port(),
                     fmt::format("POST {} HTTP/1.1\r\nHost: localhost:{}\r\nConnection: close\r\n"
                                 "Content-Length: {}\r\n\r\n{}",
                                 target, gateway.port(), body.size(), body));
  };
  const std::string answer = post("/api/protocols/check?seed=3", text);
  EXPECT_THAT(answer, HasSubstr("200 OK"));
  const json found = json::parse(answer.substr(answer.find("\r\n\r\n")));
  EXPECT_EQ(found["problem"]["key"], "kind");
  EXPECT_EQ(found["problem"]["line"], 2);
  EXPECT_THAT(post("/api/protocols/check?seed=x", text), HasSubstr("400 Bad"));
  EXPECT_THAT(post("/api/protocols", text), HasSubstr("405 Method"));
  EXPECT_THAT(post("/api/protocols/check", std::string(60'000, 'x')), HasSubstr("413 Payload"));
}

TEST(Server, TellsEveryClientThatItEnds) {
  Gateway gateway;
  Client page(gateway.port());
  Client program(gateway.port());
  ASSERT_EQ(page.open(), 101);
  ASSERT_EQ(program.open({.target = "/json", .subprotocol = ""}), 101);
  EXPECT_FALSE(page.receive_op("advertise").is_null());
  program.send_text("anything");
  EXPECT_TRUE(program.receive()) << "both have joined";
  std::thread ending([&] { gateway.stop(); });
  for (Client* client : {&page, &program}) {
    while (client->receive()) {
    }
    EXPECT_EQ(client->close_code(), 1001);
    EXPECT_EQ(client->close_reason(), "the gateway ends");
  }
  ending.join();
}

TEST(Server, AClientThatReadsNothingDoesNotKeepItFromEnding) {
  Gateway gateway;
  Client silent(gateway.port());
  ASSERT_EQ(silent.open(), 101);
  gateway.stop();
  EXPECT_ANY_THROW((void)get(gateway.port(), {.target = "/api/gateway"})) << "nobody listens any more";
}

/// Sends until the gateway ends the connection.
void attack(Client& client, const std::string& target, const std::vector<std::string>& texts) {
  ASSERT_EQ(client.open({.target = target}), 101);
  for (const auto& text : texts) client.send_text(text);
  while (client.receive()) {
  }
}

TEST(Server, WhatIsRefusedIsLoggedAndWhoIsConnectedMissesNothing) {
  const Log log;
  ServerOptions options;
  options.maximum_frame_bytes = 1000;
  std::string refused;
  {
    Gateway gateway(with_tokens(), options);
    const std::string view = "/?token=" + kViewToken;
    Client bystander(gateway.port());
    ASSERT_EQ(bystander.open({.target = view}), 101);
    bystander.subscribe(5, gateway.channel("trial/outcome"));
    std::uint8_t sent = 0;
    const auto expect_next = [&] {
      gateway.put("trial/outcome", ++sent);
      std::optional<std::string> message;
      do {
        message = bystander.receive();
        ASSERT_TRUE(message);
      } while (message->front() != '\x01');
      EXPECT_EQ(message->back(), static_cast<char>(sent));
    };
    expect_next();
    EXPECT_EQ(Client(gateway.port()).open({.target = "/?token=wrong-token-0123456789"}), 401);
    expect_next();
    EXPECT_EQ(Client(gateway.port()).open({.target = view, .origin = "https://evil.example"}), 403);
    expect_next();
    Client oversized(gateway.port());
    attack(oversized, view, {std::string(2000, 'x')});
    EXPECT_EQ(oversized.close_code(), 1009);
    expect_next();
    Client malformed(gateway.port());
    attack(malformed, view, std::vector<std::string>(10, "nonsense"));
    EXPECT_EQ(malformed.close_code(), 1008);
    expect_next();
    Client flood(gateway.port());
    attack(flood, view, std::vector<std::string>(400, R"({"op": "unadvertise", "channelIds": []})"));
    EXPECT_EQ(flood.close_code(), 1008);
    expect_next();
    refused = get(gateway.port(), {.target = "/api/status", .authorization = "Bearer " + kViewToken}).second;
  }
  const auto counts = json::parse(refused)["refused"];
  EXPECT_EQ(counts["connection"], 2);
  EXPECT_EQ(counts["oversized"], 1);
  EXPECT_GE(counts["malformed"], 9);
  EXPECT_EQ(counts["flood"], 1);
  for (const char* kind : {"(connection)", "(oversized)", "(malformed)"})
    EXPECT_THAT(log.text(), HasSubstr(kind));
  EXPECT_THAT(log.text(), ::testing::Not(HasSubstr("wrong-token"))) << "secrets are not logged";
}

}  // namespace
}  // namespace tonus::dashboard::testing
