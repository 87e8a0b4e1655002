// Attacks on the gateway over sockets: nobody is locked out, nothing leaves its place.

#include <boost/asio/write.hpp>
#include <filesystem>
#include <fstream>
#include <vector>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/dashboard/gateway_fixture.hpp"

namespace tonus::dashboard::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using tcp = asio::ip::tcp;

const std::string kViewToken = "view-token-0123456789";
const std::string kOperateToken = "operate-token-0123456789";
const std::string kView = "/?token=" + kViewToken;
const std::string kOperate = "/?token=" + kOperateToken;

Access with_tokens() { return Access({{kViewToken}, {kOperateToken}}, {}); }

/// Connections that send something, or nothing, and then stay.
class Squatters {
 public:
  explicit Squatters(std::uint16_t port) : port_(port) {}

  void add(const std::string& source, const std::string& bytes) {
    tcp::socket socket(io_, tcp::v4());
    beast::error_code error;
    socket.bind({asio::ip::make_address(source), 0}, error);
    socket.connect({asio::ip::make_address("127.0.0.1"), port_}, error);
    asio::write(socket, asio::buffer(bytes), error);
    sockets_.push_back(std::move(socket));
  }

 private:
  std::uint16_t port_;
  asio::io_context io_;
  std::vector<tcp::socket> sockets_;
};

std::string address(int i) { return "127.0.0." + std::to_string(2 + i); }

std::string get_text(const std::string& target, const std::string& header = "") {
  return "GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + header + "\r\n";
}

TEST(Attack, ConnectionsThatSayNothingLockNobodyOut) {
  Gateway gateway(with_tokens());
  Squatters squatters(gateway.port());
  for (int i = 0; i < 200; ++i) squatters.add("127.0.0.1", i % 2 == 0 ? "" : "GET / HTTP/1.1\r\nHost: ");
  EXPECT_EQ(Client(gateway.port()).open({.target = kOperate}), 101) << "from the attacker's own address";
  for (int i = 0; i < 200; ++i) squatters.add(address(i % 50), "GET");
  Client operating(gateway.port());
  EXPECT_EQ(operating.open({.target = kOperate}), 101);
  Client viewing(gateway.port(), "127.0.1.1");
  EXPECT_EQ(viewing.open({.target = kView}), 101);
  for (int i = 0; i < 200; ++i) squatters.add(address(i % 50), "");
  gateway.put("rig/state", 77);
  operating.subscribe(1, gateway.channel("rig/state"));
  EXPECT_NE(operating.receive_op("advertise"), nullptr);
  EXPECT_TRUE(operating.receive()) << "who has shown a token is not sent away";
}

TEST(Attack, ViewersFromManyAddressesLeaveRoomForOperators) {
  ServerOptions options;
  options.connections = {.all = 10, .reserve = 3, .per_address = 4};
  Gateway gateway(with_tokens(), options);
  std::vector<std::unique_ptr<Client>> viewers;
  std::vector<int> answers;
  for (int i = 0; i < 12; ++i) {
    viewers.push_back(std::make_unique<Client>(gateway.port(), address(i / 6)));
    answers.push_back(viewers.back()->open({.target = kView}));
  }
  EXPECT_EQ(answers, (std::vector<int>{101, 101, 101, 101, 503, 503, 101, 101, 101, 503, 503, 503}))
      << "four of an address, seven in all";
  Client first(gateway.port(), address(0));
  Client second(gateway.port(), address(5));
  EXPECT_EQ(first.open({.target = kOperate}), 101);
  EXPECT_EQ(second.open({.target = kOperate}), 101);
  viewers.clear();
  int again = 0;
  const auto deadline = std::chrono::steady_clock::now() + kLimit;
  while (again != 101 && std::chrono::steady_clock::now() < deadline)
    again = Client(gateway.port()).open({.target = kView});
  EXPECT_EQ(again, 101) << "their places are free again";
}

TEST(Attack, ARequestThatTricklesInIsEnded) {
  ServerOptions options;
  options.request_limit = std::chrono::milliseconds(300);
  Gateway gateway(with_tokens(), options);
  EXPECT_TRUE(is_closed_while_dripping(gateway.port(), ""));
  EXPECT_TRUE(is_closed_while_dripping(gateway.port(), "GET / HTTP/1.1\r\nX: "));
  EXPECT_TRUE(is_closed_while_dripping(gateway.port(),
                                       "GET / HTTP/1.1\r\nHost: localhost\r\n\r\nGET / HTTP/1.1\r\nX: "))
      << "after an answered one";
  EXPECT_TRUE(is_closed_while_dripping(gateway.port(),
                                       "GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n1;extension="))
      << "in the body's framing";
}

/// A masked frame of a client. opcode 0: a continuation.
std::string frame(int opcode, bool is_last, const std::string& payload) {
  std::string bytes;
  bytes.push_back(static_cast<char>((is_last ? 0x80 : 0) | opcode));
  bytes.push_back(static_cast<char>(0x80U | payload.size()));
  return bytes + std::string(4, '\0') + payload;
}

void expect_fragments_end_their_connection_only(const std::string& payload) {
  Gateway gateway;
  Client client(gateway.port());
  ASSERT_EQ(client.open(), 101);
  std::string fragments;
  for (int i = 0; i < 1000; ++i) fragments += frame(0, false, payload);
  client.send_raw(frame(1, false, payload));
  for (int i = 0; i < 200; ++i) client.send_raw(fragments);  // fails once the gateway has closed
  while (client.receive()) {
  }
  const auto refused =
      nlohmann::json::parse(get(gateway.port(), {.target = "/api/status"}).second)["refused"];
  EXPECT_EQ(refused["oversized"], 1);
  Client other(gateway.port());
  EXPECT_EQ(other.open(), 101);
}

TEST(Attack, EmptyFragmentsWithoutEndEndTheirConnectionOnly) {
  expect_fragments_end_their_connection_only("");
}

TEST(Attack, TinyFragmentsWithoutEndEndTheirConnectionOnly) {
  expect_fragments_end_their_connection_only("x");
}

TEST(Attack, AMessageInSomeFragmentsIsTakenHoweverManyCameBefore) {
  Gateway gateway;
  Client client(gateway.port());
  ASSERT_EQ(client.open(), 101);
  const std::string padding(100, ' ');
  std::string message = frame(1, false, R"({"op": "unadvertise", )");
  for (int i = 0; i < 1000; ++i) message += frame(0, false, padding);
  message += frame(0, true, R"("channelIds": []})");
  for (int i = 0; i < 10; ++i) client.send_raw(message);  // a megabyte
  client.send_text("nonsense");
  EXPECT_EQ(client.receive_op("status")["level"], 2)
      << "it is still served, and only this was not understood";
  const auto refused =
      nlohmann::json::parse(get(gateway.port(), {.target = "/api/status"}).second)["refused"];
  EXPECT_EQ(refused["malformed"], 1);
  EXPECT_EQ(refused["oversized"], 0);
}

TEST(Attack, ATokenGoesIntoAHeaderOnlyWhenItIsOneOfTheTokens) {
  const std::string evil = "%0d%0aSet-Cookie:%20evil=1%0d%0aX:%20" + kViewToken;
  const std::string good = "Authorization: Bearer " + kViewToken + "\r\n";
  {
    Gateway gateway(with_tokens());
    EXPECT_THAT(answer_to(gateway.port(), get_text("/reports/a?token=" + evil, good)),
                Not(HasSubstr("evil")));
    EXPECT_THAT(answer_to(gateway.port(), get_text("/reports/a?token=" + kViewToken + evil, good)),
                Not(HasSubstr("evil")));
    EXPECT_THAT(answer_to(gateway.port(), get_text("/reports/a?token=other-token-0123456789", good)),
                Not(HasSubstr("other-token")));
    EXPECT_THAT(answer_to(gateway.port(), get_text("/reports/a?token=" + kViewToken)),
                HasSubstr("Set-Cookie: tonus-report=" + kViewToken + ";"));
  }
  Gateway open_to_all;
  EXPECT_THAT(answer_to(open_to_all.port(), get_text("/reports/a?token=" + evil)), Not(HasSubstr("evil")));
  EXPECT_THAT(answer_to(open_to_all.port(), get_text("/reports/a?token=" + kViewToken)),
              Not(HasSubstr("Set-Cookie")));
}

TEST(Attack, NoAddressLeavesTheFolderOfTheReports) {
  const tonus::testing::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "reports" / "in");
  std::ofstream(folder / "secret.txt") << "hidden";
  std::ofstream(folder / "reports" / "in" / "good.txt") << "shown";
  std::filesystem::create_symlink(folder / "secret.txt", folder / "reports" / "link.txt");
  ServerOptions options;
  options.folders.reports = folder / "reports";
  Gateway gateway(Access({}, {}), options);
  EXPECT_THAT(answer_to(gateway.port(), get_text("/reports/in/good.txt")), HasSubstr("shown"));
  const std::string absolute = (folder / "secret.txt").string();
  for (const std::string& path :
       {std::string("../secret.txt"), std::string("in/../../secret.txt"), std::string("%2e%2e/secret.txt"),
        std::string("..%2fsecret.txt"), std::string("..\\secret.txt"), std::string("link.txt"), absolute,
        "/" + absolute, std::string("in/good.txt/../../../secret.txt")}) {
    const std::string answer = answer_to(gateway.port(), get_text("/reports/" + path));
    EXPECT_THAT(answer, HasSubstr("404")) << path;
    EXPECT_THAT(answer, Not(HasSubstr("hidden"))) << path;
  }
  for (const char* target : {"/../secret.txt", "/api/sessions/../../secret.txt", "/reports/../../secret.txt",
                             "//etc/passwd", "/assets/../../secret.txt"}) {
    const std::string answer = answer_to(gateway.port(), get_text(target));
    EXPECT_THAT(answer, Not(HasSubstr("hidden"))) << target;
    EXPECT_THAT(answer, Not(HasSubstr("root:"))) << target;
  }
}

}  // namespace
}  // namespace tonus::dashboard::testing
