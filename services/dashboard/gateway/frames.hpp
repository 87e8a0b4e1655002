#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "services/bus/bus.hpp"
#include "services/core/result.hpp"

/// What goes over a WebSocket of the subprotocol foxglove.websocket.v1: text frames hold one JSON object with
/// an "op", binary frames begin with one byte that says what they are; numbers are little endian.
/// Source: docs/spec.md of github.com/foxglove/ws-protocol.
namespace tonus::dashboard {

inline constexpr char kSubprotocol[] = "foxglove.websocket.v1";

/// A channel as it is offered to clients.
struct Channel {
  std::uint32_t id = 0;
  std::string topic;
  std::string encoding;         ///< "cdr" or "json".
  std::string schema_name;      ///< "tonus::v1::RigState".
  std::string schema;           ///< The whole text, self-contained.
  std::string schema_encoding;  ///< "omgidl" or "jsonschema".
};

struct ServerInfo {
  std::string name;
  std::string session;  ///< Another one after each start of the gateway.
  std::vector<std::pair<std::string, std::string>> metadata;
};

enum class StatusLevel : std::uint8_t { kInfo = 0, kWarning = 1, kError = 2 };

[[nodiscard]] std::string server_info_text(const ServerInfo& info);
[[nodiscard]] std::string advertise_text(const std::vector<Channel>& channels);
[[nodiscard]] std::string status_text(StatusLevel level, std::string_view message);
/// `{"error": "..."}`, as HTTP and JSON clients get it.
[[nodiscard]] std::string error_text(std::string_view message);

/// The 13 bytes before a message's payload: opcode, subscription, time (ns of UTC).
[[nodiscard]] std::string message_head(std::uint32_t subscription, std::uint64_t time_ns);

/// One WebSocket message on its way to a client: a head of its own and a body that many may share.
struct Outgoing {
  std::string head;
  std::shared_ptr<const bus::Payload> body;  ///< May be null.
  bool is_text = false;

  [[nodiscard]] std::size_t bytes() const { return head.size() + (body ? body->size() : 0); }
};

// What clients may say.

struct Subscription {
  std::uint32_t id = 0;
  std::uint32_t channel = 0;
};

struct Subscribe {
  std::vector<Subscription> subscriptions;
};

struct Unsubscribe {
  std::vector<std::uint32_t> ids;
};

struct ClientChannel {
  std::uint32_t id = 0;
  std::string topic;
  std::string encoding;
};

struct ClientAdvertise {
  std::vector<ClientChannel> channels;
};

struct ClientUnadvertise {
  std::vector<std::uint32_t> ids;
};

using ClientSaying = std::variant<Subscribe, Unsubscribe, ClientAdvertise, ClientUnadvertise>;

/// kInvalidArgument names what is wrong with the text; never throws.
[[nodiscard]] Result<ClientSaying> parse_client_text(std::string_view text);

struct ClientMessage {
  std::uint32_t channel = 0;
  std::span<const std::byte> data;  ///< Into the frame.
};

[[nodiscard]] Result<ClientMessage> parse_client_binary(std::span<const std::byte> frame);

}  // namespace tonus::dashboard
