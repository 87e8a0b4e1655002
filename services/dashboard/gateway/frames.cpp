#include "services/dashboard/gateway/frames.hpp"

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "services/core/json_text.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;

constexpr char kMessageData = 0x01;
constexpr std::byte kClientMessageData{0x01};
constexpr std::size_t kClientHeadBytes = 5;
constexpr std::size_t kMaximumItems = 1024;
constexpr std::size_t kMaximumNameBytes = 256;

template <typename Number>
void append_little_endian(std::string& out, Number number) {
  for (std::size_t i = 0; i < sizeof(Number); ++i)
    out.push_back(static_cast<char>(static_cast<unsigned char>((number >> (8 * i)) & 0xffU)));
}

Error malformed(const std::string& what) { return fail(ErrorCode::kInvalidArgument, what); }

Result<const json*> list_of(const json& object, const char* field) {
  const auto found = object.find(field);
  if (found == object.end() || !found->is_array())
    return malformed(fmt::format("\"{}\" is missing; expected a list", field));
  if (found->size() > kMaximumItems) {
    return malformed(
        fmt::format("\"{}\" has {} items, at most {} are allowed", field, found->size(), kMaximumItems));
  }
  return &*found;
}

Result<std::uint32_t> number_of(const json& value, const char* what) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 0xffffffffU)
    return malformed(fmt::format("{} must be a whole number from 0 to 4294967295", what));
  return value.get<std::uint32_t>();
}

Result<std::uint32_t> number_in(const json& object, const char* field) {
  if (!object.is_object() || !object.contains(field))
    return malformed(fmt::format("\"{}\" is missing; expected a number", field));
  return number_of(object.at(field), field);
}

Result<std::string> name_in(const json& object, const char* field) {
  const auto found = object.find(field);
  if (found == object.end() || !found->is_string())
    return malformed(fmt::format("\"{}\" is missing; expected text", field));
  auto text = found->get<std::string>();
  if (text.size() > kMaximumNameBytes) {
    return malformed(
        fmt::format("\"{}\" has {} bytes, at most {} are allowed", field, text.size(), kMaximumNameBytes));
  }
  return text;
}

Result<std::vector<std::uint32_t>> numbers_in(const json& object, const char* field) {
  const auto list = list_of(object, field);
  if (!list) return list.error();
  std::vector<std::uint32_t> numbers;
  for (const json& item : **list) {
    const auto number = number_of(item, field);
    if (!number) return number.error();
    numbers.push_back(*number);
  }
  return numbers;
}

Result<ClientSaying> parse_subscribe(const json& object) {
  const auto list = list_of(object, "subscriptions");
  if (!list) return list.error();
  Subscribe result;
  for (const json& item : **list) {
    const auto id = number_in(item, "id");
    if (!id) return id.error();
    const auto channel = number_in(item, "channelId");
    if (!channel) return channel.error();
    result.subscriptions.push_back({*id, *channel});
  }
  return ClientSaying(std::move(result));
}

Result<ClientSaying> parse_advertise(const json& object) {
  const auto list = list_of(object, "channels");
  if (!list) return list.error();
  ClientAdvertise result;
  for (const json& item : **list) {
    const auto id = number_in(item, "id");
    if (!id) return id.error();
    const auto topic = name_in(item, "topic");
    if (!topic) return topic.error();
    const auto encoding = name_in(item, "encoding");
    if (!encoding) return encoding.error();
    result.channels.push_back({*id, *topic, *encoding});
  }
  return ClientSaying(std::move(result));
}

template <typename Saying>
Result<ClientSaying> parse_ids(const json& object, const char* field) {
  auto ids = numbers_in(object, field);
  if (!ids) return ids.error();
  return ClientSaying(Saying{std::move(*ids)});
}

}  // namespace

std::string server_info_text(const ServerInfo& info) {
  json metadata = json::object();
  for (const auto& [name, value] : info.metadata) metadata[name] = value;
  return json{{"op", "serverInfo"},
              {"name", info.name},
              {"capabilities", {"clientPublish"}},
              {"supportedEncodings", {"json"}},
              {"metadata", metadata},
              {"sessionId", info.session}}
      .dump();
}

std::string advertise_text(const std::vector<Channel>& channels) {
  json list = json::array();
  for (const Channel& channel : channels) {
    list.push_back({{"id", channel.id},
                    {"topic", channel.topic},
                    {"encoding", channel.encoding},
                    {"schemaName", channel.schema_name},
                    {"schema", channel.schema},
                    {"schemaEncoding", channel.schema_encoding}});
  }
  return json{{"op", "advertise"}, {"channels", list}}.dump();
}

std::string error_text(std::string_view message) { return json_text(json{{"error", message}}, -1); }

std::string status_text(StatusLevel level, std::string_view message) {
  return json{{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}}.dump(
      -1, ' ', false, json::error_handler_t::replace);
}

std::string message_head(std::uint32_t subscription, std::uint64_t time_ns) {
  std::string head(1, kMessageData);
  append_little_endian(head, subscription);
  append_little_endian(head, time_ns);
  return head;
}

Result<ClientSaying> parse_client_text(std::string_view text) {
  const json object = json::parse(text, nullptr, false);
  if (object.is_discarded() || !object.is_object())
    return malformed("a text frame must be one JSON object with an \"op\"");
  const auto op = name_in(object, "op");
  if (!op) return op.error();
  if (*op == "subscribe") return parse_subscribe(object);
  if (*op == "unsubscribe") return parse_ids<Unsubscribe>(object, "subscriptionIds");
  if (*op == "advertise") return parse_advertise(object);
  if (*op == "unadvertise") return parse_ids<ClientUnadvertise>(object, "channelIds");
  return malformed(
      fmt::format("op \"{}\" is not offered; subscribe, unsubscribe, advertise and unadvertise are", *op));
}

Result<ClientMessage> parse_client_binary(std::span<const std::byte> frame) {
  if (frame.empty() || frame[0] != kClientMessageData)
    return malformed("a binary frame must begin with the opcode 1 (message data)");
  if (frame.size() < kClientHeadBytes) {
    return malformed(fmt::format("a binary frame of {} bytes has no room for its channel; expected 5 or more",
                                 frame.size()));
  }
  std::uint32_t channel = 0;
  for (std::size_t i = 0; i < 4; ++i) channel |= std::to_integer<std::uint32_t>(frame[1 + i]) << (8 * i);
  return ClientMessage{channel, frame.subspan(kClientHeadBytes)};
}

}  // namespace tonus::dashboard
