#include "tests/support/gateway_client/gateway_client.hpp"

#include <array>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <functional>

namespace tonus::dashboard::testing {
namespace {

using tcp = asio::ip::tcp;

tcp::endpoint endpoint(std::uint16_t port) { return {asio::ip::make_address("127.0.0.1"), port}; }

std::string host_of(const Headers& headers, std::uint16_t port) {
  return headers.host.empty() ? "localhost:" + std::to_string(port) : headers.host;
}

template <typename Fields>
void set(Fields& fields, const Headers& headers) {
  if (!headers.origin.empty()) fields.set(http::field::origin, headers.origin);
  if (!headers.authorization.empty()) fields.set(http::field::authorization, headers.authorization);
  if (!headers.cookie.empty()) fields.set(http::field::cookie, headers.cookie);
}

}  // namespace

Client::Client(std::uint16_t port, std::string source) : port_(port), source_(std::move(source)) {}

template <typename Begin>
beast::error_code Client::wait(const Begin& begin) {
  beast::error_code outcome = beast::error::timeout;
  bool is_over = false;
  begin([&](beast::error_code error, auto...) {
    outcome = error;
    is_over = true;
  });
  io_.restart();
  const auto deadline = std::chrono::steady_clock::now() + kLimit;
  while (!is_over && io_.run_one_until(deadline) > 0) {
  }
  if (!is_over) {  // it must not call back into this frame any more
    ws_.next_layer().close();
    io_.restart();
    io_.run();
    return beast::error::timeout;
  }
  return outcome;
}

int Client::open(const Headers& headers) {
  auto& socket = ws_.next_layer().socket();
  socket.open(tcp::v4());
  socket.bind({asio::ip::make_address(source_), 0});
  if (wait([&](auto done) { ws_.next_layer().async_connect(endpoint(port_), done); })) return 0;
  ws_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
    set(request, headers);
    if (!headers.subprotocol.empty()) request.set(http::field::sec_websocket_protocol, headers.subprotocol);
  }));
  ws_.read_message_max(64 << 20);
  websocket::response_type response;
  const auto error =
      wait([&](auto done) { ws_.async_handshake(response, host_of(headers, port_), headers.target, done); });
  if (error && error != websocket::error::upgrade_declined) return 0;
  return static_cast<int>(response.result_int());
}

void Client::send_text(const std::string& text) {
  ws_.text(true);
  (void)wait([&](auto done) { ws_.async_write(asio::buffer(text), done); });
}

void Client::send_binary(const std::string& bytes) {
  ws_.binary(true);
  (void)wait([&](auto done) { ws_.async_write(asio::buffer(bytes), done); });
}

void Client::send_raw(const std::string& bytes) {
  (void)wait([&](auto done) { asio::async_write(ws_.next_layer(), asio::buffer(bytes), done); });
}

void Client::subscribe(std::uint32_t id, std::uint32_t channel) {
  send_text(
      nlohmann::json{{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}}.dump());
}

std::optional<std::string> Client::receive() {
  beast::flat_buffer buffer;
  if (wait([&](auto done) { ws_.async_read(buffer, done); })) {
    close_code_ = ws_.reason().code;
    return std::nullopt;
  }
  return beast::buffers_to_string(buffer.data());
}

nlohmann::json Client::receive_op(const std::string& op) {
  while (const auto message = receive()) {
    const auto object = nlohmann::json::parse(*message, nullptr, false);
    if (object.is_object() && object.value("op", "") == op) return object;
  }
  return nullptr;
}

std::pair<int, std::string> get(std::uint16_t port, const Headers& headers) {
  asio::io_context io;
  beast::tcp_stream stream(io);
  stream.connect(endpoint(port));
  http::request<http::empty_body> request(http::verb::get, headers.target, 11);
  request.set(http::field::host, host_of(headers, port));
  set(request, headers);
  http::write(stream, request);
  beast::flat_buffer buffer;
  http::response<http::string_body> response;
  http::read(stream, buffer, response);
  return {static_cast<int>(response.result_int()), response.body()};
}

std::string answer_to(std::uint16_t port, const std::string& bytes) {
  asio::io_context io;
  tcp::socket socket(io);
  socket.connect(endpoint(port));
  beast::error_code error;
  asio::write(socket, asio::buffer(bytes), error);
  std::string answer;
  bool is_over = false;
  asio::async_read(socket, asio::dynamic_buffer(answer),
                   [&](beast::error_code, std::size_t) { is_over = true; });
  const auto deadline = std::chrono::steady_clock::now() + kLimit;
  while (!is_over && io.run_one_until(deadline) > 0) {
  }
  return answer;
}

bool is_closed_while_dripping(std::uint16_t port, const std::string& begin) {
  asio::io_context io;
  tcp::socket socket(io);
  socket.connect(endpoint(port));
  beast::error_code error;
  asio::write(socket, asio::buffer(begin), error);
  bool is_closed = false;
  std::array<char, 256> answer{};
  const std::function<void()> read = [&] {
    socket.async_read_some(asio::buffer(answer), [&](beast::error_code ended, std::size_t) {
      is_closed = static_cast<bool>(ended);
      if (!is_closed) read();
    });
  };
  read();
  const auto deadline = std::chrono::steady_clock::now() + kLimit;
  while (!is_closed && std::chrono::steady_clock::now() < deadline) {
    (void)io.run_one_for(std::chrono::milliseconds(10));
    if (!begin.empty()) asio::write(socket, asio::buffer("a", 1), error);
  }
  return is_closed;
}

}  // namespace tonus::dashboard::testing
