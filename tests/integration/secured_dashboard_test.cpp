// The pages of a secured domain: a dashboard with its certificate shows and steers, one without gets nothing.
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <sys/stat.h>

#include "services/core/id.hpp"
#include "services/pki/authority.hpp"
#include "tests/support/gateway_client/gateway_client.hpp"
#include "tests/support/process.hpp"
#include "tests/support/short_session.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {
namespace {

using dashboard::testing::Client;
using dashboard::testing::get;
using nlohmann::json;
using ::testing::HasSubstr;

constexpr std::chrono::seconds kLimit{90};
constexpr char kView[] = "view-token-0123456789";
constexpr char kOperate[] = "operate-token-0123456789";

/// A gateway's port, once it has said where it serves; 0: it does not.
std::uint16_t port_of(Process& process, const std::string& says) {
  if (!process.wait_for_output(says + "http://127.0.0.1:", kLimit)) return 0;
  const auto text = process.output();
  const auto at = text.rfind("http://127.0.0.1:") + std::string("http://127.0.0.1:").size();
  return static_cast<std::uint16_t>(std::stoi(text.substr(at)));
}

/// What the gateway answers for this path, as an operator's page asks.
json ask(std::uint16_t port, const std::string& path) {
  const auto [status, body] = get(port, {.target = path, .authorization = "Bearer " + std::string(kOperate)});
  return status == 200 ? json::parse(body, nullptr, false) : json();
}

/// The newest state of the rig that the gateway has; null: none.
json rig_state(std::uint16_t port) {
  for (const json& message : ask(port, "/api/states"))
    if (message["topic"] == "rig/state") return message["message"];
  return nullptr;
}

bool eventually(const std::function<bool()>& is_true) {
  const auto deadline = std::chrono::steady_clock::now() + kLimit;
  while (std::chrono::steady_clock::now() < deadline)
    if (is_true()) return true;
  return false;
}

/// A page that asks: `fields` beside the request's name. The gateway's answer.
json request(std::uint16_t port, const char* token, const std::string& name, json fields = json::object()) {
  Client page(port);
  EXPECT_EQ(page.open({.target = "/?token=" + std::string(token)}), 101);
  std::uint32_t replies = 0;
  const json offered = page.receive_op("advertise");
  for (const json& channel : offered["channels"])
    if (channel["topic"] == "operator/reply") replies = channel["id"];
  page.subscribe(1, replies);
  page.send_text(R"({"op": "advertise", "channels": [
      {"id": 1, "topic": "operator/request", "encoding": "json", "schemaName": "x"}]})");
  fields["request_id"] = to_hex(random_id());
  fields["request"] = name;
  page.send_binary(std::string("\x01\x01\0\0\0", 5) + fields.dump());
  while (const auto message = page.receive()) {
    if (message->front() != '\x01') continue;
    json reply = json::parse(message->substr(dashboard::message_head(1, 0).size()));
    if (reply["request_id"] == fields["request_id"]) return reply;
  }
  return nullptr;
}

/// One host with every role of a lab, and the services on it.
class SecuredDashboard : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const auto now = std::chrono::system_clock::now();
    authority_.emplace(*pki::Authority::create(folder_ / "pki", GetParam(), std::chrono::days(9), now));
    ASSERT_TRUE(authority_->issue(
        {.host = "host", .roles = {"rig", "services", "dashboard", "operator"}, .rigs = {"rig"}}, now));
    std::ofstream(folder_ / "tokens.toml")
        << "view = [\"" << kView << "\"]\noperate = [\"" << kOperate << "\"]\n";
    chmod((folder_ / "tokens.toml").c_str(), 0600);
    write_short_protocol(folder_ / "protocol.toml", 4);
    // On a busy machine ten participants may take longer to authenticate each other than `tonus up` waits.
    for (int attempt = 0; attempt < 3 && port_ == 0; ++attempt) {
      system_.emplace(program("tonus"),
                      options_of("host", {"up", "--speed", "max", "--dashboard", "--dashboard-listen",
                                          "127.0.0.1:0", "--dashboard-tokens", folder_ / "tokens.toml"}),
                      folder_ / "up.log");
      port_ = port_of(*system_, "dashboard serves ");
    }
    ASSERT_NE(port_, 0) << system_->output();
  }

  /// Of a program with the certificates of that host; empty: with none.
  [[nodiscard]] std::vector<std::string> options_of(const std::string& host,
                                                    std::vector<std::string> words) const {
    words.insert(words.end(), {"--dds", GetParam(), "--domain", std::to_string(domain_), "--data",
                               (folder_ / "data").string()});
    if (!host.empty()) words.insert(words.end(), {"--security", certificates_of(host)});
    return words;
  }
  [[nodiscard]] std::string certificates_of(const std::string& host) const {
    return (folder_.path() / "pki" / "hosts" / host).string();
  }
  [[nodiscard]] std::unique_ptr<Process> start_dashboard(std::vector<std::string> options) {
    options.insert(options.end(), {"--listen", "127.0.0.1:0", "--tokens", folder_ / "tokens.toml"});
    return std::make_unique<Process>(program("tonus-dashboard"), options,
                                     folder_ / ("dashboard-" + std::to_string(++started_) + ".log"));
  }

  int domain_ = own_domain();
  TemporaryFolder folder_;
  std::optional<pki::Authority> authority_;
  std::optional<Process> system_;
  std::uint16_t port_ = 0;
  int started_ = 0;
};
INSTANTIATE_TEST_SUITE_P(Vendors, SecuredDashboard, ::testing::Values("fastdds", "cyclonedds"),
                         [](const auto& vendor) { return std::string(vendor.param); });

TEST_P(SecuredDashboard, ShowsASessionAndItsOperatorSteersWhileAViewerOnlyReadsAndStops) {
  Process session(program("tonus"), options_of("host", {"run", folder_ / "protocol.toml"}),
                  folder_ / "run.log");
  ASSERT_EQ(session.wait(kLimit), 0) << session.output();
  ASSERT_TRUE(eventually([&] { return !ask(port_, "/api/estimates").empty(); }));
  EXPECT_FALSE(ask(port_, "/api/verdicts").empty());
  EXPECT_EQ(ask(port_, "/api/rigs").size(), 1U);
  ASSERT_TRUE(eventually([&] { return !rig_state(port_).is_null(); }));

  for (const char* beyond : {"abort", "pause", "resume", "abort_trial"}) {
    const json refused = request(port_, kView, beyond);
    EXPECT_EQ(refused["is_done"], false) << refused;
    EXPECT_THAT(refused["message"].get<std::string>(), HasSubstr("only for emergency_stop")) << refused;
  }
  EXPECT_EQ(rig_state(port_)["mode"], "free");
  const json stopped = request(port_, kView, "emergency_stop");
  EXPECT_EQ(stopped["is_done"], true) << stopped;
  ASSERT_TRUE(eventually([&] { return rig_state(port_)["mode"] == "held"; }));
  const json hold = {{"hold_number", rig_state(port_)["hold_number"]}};
  EXPECT_EQ(request(port_, kView, "clear_fault", hold)["is_done"], false);
  EXPECT_EQ(rig_state(port_)["mode"], "held");
  const json cleared = request(port_, kOperate, "clear_fault", hold);
  EXPECT_EQ(cleared["is_done"], true) << cleared;
  EXPECT_TRUE(eventually([&] { return rig_state(port_)["mode"] == "free"; }));
}

TEST_P(SecuredDashboard, OfAnotherAuthorityOrWithoutACertificateShowsNothingAndStopsNothing) {
  const auto now = std::chrono::system_clock::now();
  auto other = pki::Authority::create(folder_ / "other", GetParam(), std::chrono::days(9), now);
  ASSERT_TRUE(other) << other.error().message;
  const auto foreign = other->issue({.host = "host", .roles = {"dashboard"}}, now);
  ASSERT_TRUE(foreign) << foreign.error().message;
  auto with_foreign = options_of("", {});
  with_foreign.insert(with_foreign.end(), {"--security", foreign->string()});
  for (const auto& options : {options_of("", {}), with_foreign}) {
    const auto outside = start_dashboard(options);
    const auto outside_port = port_of(*outside, "dashboard: ");
    ASSERT_NE(outside_port, 0) << outside->output();
    // One with its certificate that starts later has been told: so the other could have been.
    const auto inside = start_dashboard(options_of("host", {}));
    const auto inside_port = port_of(*inside, "dashboard: ");
    ASSERT_NE(inside_port, 0) << inside->output();
    ASSERT_TRUE(eventually([&] { return !rig_state(inside_port).is_null(); })) << inside->output();
    EXPECT_TRUE(rig_state(outside_port).is_null());
    EXPECT_TRUE(ask(outside_port, "/api/rigs").empty());
    const json stopped = request(outside_port, kOperate, "emergency_stop");
    EXPECT_EQ(stopped["is_done"], false) << stopped;
    EXPECT_EQ(rig_state(port_)["mode"], "free");
  }
}

TEST_P(SecuredDashboard, WithoutThatRoleOrWithACertificateThatIsOverDoesNotStartAndSaysWhy) {
  const auto now = std::chrono::system_clock::now();
  ASSERT_TRUE(authority_->issue({.host = "guest", .roles = {"viewer"}}, now));
  ASSERT_TRUE(authority_->issue({.host = "lost", .roles = {"dashboard"}}, now));
  ASSERT_TRUE(authority_->revoke("lost", "", now));
  ASSERT_TRUE(authority_->issue({.host = "late", .roles = {"dashboard"}, .validity = std::chrono::days(1)},
                                now - std::chrono::days(3)));
  for (const auto& [host, why] : {std::pair{"guest", "this host has no identity 'dashboard'"},
                                  {"lost", "revoked"},
                                  {"late", "expired"}}) {
    const auto refused = start_dashboard(options_of(host, {}));
    EXPECT_EQ(refused->wait(kLimit), 1) << host << ": " << refused->output();
    EXPECT_THAT(refused->output(), HasSubstr(why)) << host;
  }
}

}  // namespace
}  // namespace tonus::testing
