#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "services/dashboard/gateway/frames.hpp"

/// The other end of a gateway on this machine's loopback: HTTP and WebSockets.
namespace tonus::dashboard::testing {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

constexpr std::chrono::seconds kLimit{20};

struct Headers {
  std::string target = "/";
  std::string host{};  ///< Empty: localhost and the port.
  std::string origin{};
  std::string authorization{};
  std::string cookie{};
  std::string subprotocol = kSubprotocol;
};

/// A WebSocket's client that waits for everything, up to kLimit.
class Client {
 public:
  /// `source`: this machine's address that it comes from.
  explicit Client(std::uint16_t port, std::string source = "127.0.0.1");

  /// HTTP status: 101 where the WebSocket stands.
  [[nodiscard]] int open(const Headers& headers = {});
  void send_text(const std::string& text);
  void send_binary(const std::string& bytes);
  /// Bytes as they are, below the WebSocket; until the gateway closes.
  void send_raw(const std::string& bytes);
  void subscribe(std::uint32_t id, std::uint32_t channel);

  /// The next message; none when the connection has ended, see close_code().
  [[nodiscard]] std::optional<std::string> receive();
  /// The next text message with this "op".
  [[nodiscard]] nlohmann::json receive_op(const std::string& op);
  [[nodiscard]] int close_code() const { return close_code_; }
  [[nodiscard]] std::string close_reason() const { return ws_.reason().reason.c_str(); }
  [[nodiscard]] beast::tcp_stream& socket() { return ws_.next_layer(); }

 private:
  /// Runs the operation that `begin` starts, to its end or to kLimit.
  template <typename Begin>
  [[nodiscard]] beast::error_code wait(const Begin& begin);

  asio::io_context io_;
  websocket::stream<beast::tcp_stream> ws_{io_};
  std::uint16_t port_;
  std::string source_;
  int close_code_ = 0;
};

/// Status and body of a GET, "200 text".
[[nodiscard]] std::pair<int, std::string> get(std::uint16_t port, const Headers& headers);

/// What the server answers to these bytes, until it closes or kLimit is over.
[[nodiscard]] std::string answer_to(std::uint16_t port, const std::string& bytes);

/// Sends `begin`, and one byte more as soon as each has gone, slowly. Whether the gateway ends it within
/// kLimit.
[[nodiscard]] bool is_closed_while_dripping(std::uint16_t port, const std::string& begin);

}  // namespace tonus::dashboard::testing
