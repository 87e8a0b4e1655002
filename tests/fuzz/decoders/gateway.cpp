// What browsers send to the dashboard.

#include <filesystem>

#include "services/dashboard/gateway/access.hpp"
#include "services/dashboard/gateway/http_api.hpp"
#include "services/dashboard/gateway/hub.hpp"
#include "services/dashboard/gateway/operator_request.hpp"
#include "tests/fuzz/decoders/decoder.hpp"

namespace tonus::fuzz {
namespace {

namespace fs = std::filesystem;

class Link final : public dashboard::ClientLink {
 public:
  void wake() override {}
  void end(dashboard::CloseCode, const std::string& reason) override {
    require(reason.size() <= 123, "a close reason fits a WebSocket's close frame");
  }
};

constexpr std::string_view kSecret = "a secret of the machine's own";

/// A folder of pages' files, beside which lies one that nobody may have.
const dashboard::ApiFolders& folders() {
  static const dashboard::ApiFolders kFolders = [] {
    const fs::path root = fs::path(scratch_folder()) / "api";
    for (const char* name : {"protocols", "reports/study"}) fs::create_directories(root / name);
    write_bytes((root / "secret.toml").string(), bytes_of(kSecret));
    write_bytes((root / "protocols/a.toml").string(), bytes_of("kind = \"unloaded\"\n"));
    write_bytes((root / "reports/study/report.html").string(), bytes_of("<p>report</p>"));
    return dashboard::ApiFolders{(root / "archive.sqlite").string(), root / "protocols", root / "reports"};
  }();
  return kFolders;
}

void put_frame(Bytes& input, int kind, std::string_view content) {
  input.push_back(static_cast<std::byte>(kind));
  put_part(input, bytes_of(content));
}

const char kStart[] =
    R"({"request_id": "00112233445566778899aabbccddeeff", "request": "start", "session_id": "0123456789abcdef0123456789abcdef",)"
    R"( "protocol_toml": "kind = 1", "subject": "sub-01", "seed": 1, "by": "Anna", "page": "operator"})";

}  // namespace

/// Frames of one client, each a kind (even: text, odd: binary) and a part.
void read_websocket(std::span<const std::byte> input) {
  ManualClock clock;
  dashboard::Hub::Options options;
  options.frames_burst = 1e6;
  options.malformed_burst = 1e6;
  static const auto kTopics = [] {
    auto topics = dashboard::offered_topics();
    for (auto& topic : topics) topic.channel.schema.clear();  // long texts that say nothing here
    return topics;
  }();
  dashboard::Hub hub(kTopics, options, clock,
                     [](const auto& request) { require(!request.name.empty(), "what is asked has a name"); });
  Link link;
  const auto client = hub.join(link, dashboard::Role::kOperate, "127.0.0.1:1");
  for (Parts parts(input); !parts.is_empty();) {
    const bool is_text = parts.byte() % 2 == 0;
    const auto content = parts.part();
    is_text ? hub.on_text(client, text_of(content)) : hub.on_binary(client, content);
    while (hub.next(client)) {
    }
  }
  hub.publish_status(0);
  static_cast<void>(hub.status_json(0));
  hub.leave(client);
}

std::vector<Bytes> websocket_seeds() {
  Bytes input;
  put_frame(
      input, 0,
      R"({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}, {"id": 2, "channelId": 28}]})");
  put_frame(
      input, 0,
      R"({"op": "advertise", "channels": [{"id": 7, "topic": "operator/request", "encoding": "json", "schemaName": ""}]})");
  put_frame(input, 1, std::string("\x01\x07\x00\x00\x00", 5) + kStart);
  put_frame(input, 0, R"({"op": "unsubscribe", "subscriptionIds": [1]})");
  put_frame(input, 0, R"({"op": "unadvertise", "channelIds": [7]})");
  return {input};
}

void read_request(std::span<const std::byte> input) {
  for (const auto role : {dashboard::Role::kView, dashboard::Role::kOperate}) {
    Id id{};
    std::string name;
    const auto request = dashboard::parse_request(
        text_of(input), {role, "dashboard 127.0.0.1:1", id_of("rig/fuzz"), 1}, id, name);
    require_message(request);
    if (!request) continue;
    require(dashboard::is_allowed(role, request->name), "who may not ask for it is refused");
    require(!dashboard::reply_text({request->id, request->name, true, "done", request->requested_by}).empty(),
            "a reply says something");
  }
}

std::vector<Bytes> request_seeds() {
  std::vector<Bytes> seeds{bytes_of(kStart)};
  for (const std::string_view name :
       {"pause", "resume", "abort", "emergency_stop", "clear_fault", "abort_trial"})
    seeds.push_back(
        bytes_of(R"({"request_id": "00112233445566778899aabbccddeeff", "hold_number": 1, "request": ")" +
                 std::string(name) + "\"}"));
  return seeds;
}

/// A target, and a header.
void read_http(std::span<const std::byte> input) {
  Parts parts(input);
  const std::string_view target = text_of(parts.part());
  const std::string_view header = text_of(parts.rest());
  const auto answer = dashboard::answer_api(folders(), target.substr(0, target.find('?')),
                                            dashboard::query_value(target, "topic"));
  require(answer.status >= 200 && answer.status < 600, "an answer has a status");
  require(answer.body.find(kSecret) == std::string::npos, "nothing is served from beside the folders");
  static_cast<void>(dashboard::query_value(target, "token"));
  static_cast<void>(dashboard::cookie_value(header, "token"));
  static_cast<void>(dashboard::is_loopback_name(header));
  const dashboard::Access access({{"view-token-0123456789"}, {"operate-token-0123456789"}}, {});
  const std::string text(header);
  const auto admitted = access.admit({text, text, text, dashboard::query_value(target, "token"), false});
  if (std::holds_alternative<dashboard::Refusal>(admitted))
    require(!std::get<dashboard::Refusal>(admitted).reason.empty(), "a refusal says why");
}

std::vector<Bytes> http_seeds() {
  std::vector<Bytes> seeds;
  for (const std::string_view target :
       {"/api/protocols", "/api/sessions/00112233445566778899aabbccddeeff/messages?topic=session/plan",
        "/reports/study/report.html", "/reports/%2e%2e/secret.toml", "/reports/../secret.toml",
        "/?token=a%2Bb"}) {
    seeds.emplace_back();
    put_part(seeds.back(), bytes_of(target));
    const Bytes header = bytes_of("Bearer view-token-0123456789; token=abc; localhost:8765");
    seeds.back().insert(seeds.back().end(), header.begin(), header.end());
  }
  return seeds;
}

}  // namespace tonus::fuzz
