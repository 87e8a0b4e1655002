#pragma once

#include <array>
#include <boost/asio/dispatch.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <memory>
#include <optional>
#include <string>

#include "services/dashboard/gateway/server_core.hpp"

namespace tonus::dashboard {

/// A WebSocket between a client and the hub: one message under way in each direction, the rest waits in the
/// hub's outbox. `Stream` is a TCP or a TLS stream of Boost.Beast.
template <typename Stream>
class WebSocketClient final : public ClientLink,
                              public std::enable_shared_from_this<WebSocketClient<Stream>> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;

  WebSocketClient(ServerCore& core, Stream&& stream, Role role, std::string peer, Seat seat)
      : core_(core),
        seat_(std::move(seat)),
        stream_(std::move(stream)),
        last_resort_(core.io),
        role_(role),
        peer_(std::move(peer)) {}
  ~WebSocketClient() override {
    if (id_ == 0) return;
    core_.hub.leave(id_);
    core_.wants_changed(core_.hub);
  }

  /// For the subprotocol foxglove.websocket.v1.
  void accept(const Request& request) { shake_hands(request, kSubprotocol); }

  /// For JSON of these topics.
  void accept_json(const Request& request, std::vector<std::string_view> topics) {
    json_topics_ = std::move(topics);
    shake_hands(request, {});
  }

  void wake() override {
    if (is_woken_) return;
    is_woken_ = true;
    boost::asio::post(core_.io, [self = this->shared_from_this()] {
      self->is_woken_ = false;
      self->write();
    });
  }

  void end(CloseCode code, const std::string& reason) override {
    if (closing_) return;
    closing_.emplace(static_cast<boost::beast::websocket::close_code>(code),
                     reason.substr(0, kLongestReason));
    // Whoever does not read does not hear the reason either.
    last_resort_.expires_after(kCloseLimit);
    last_resort_.async_wait([self = this->shared_from_this()](boost::beast::error_code ended) {
      if (!ended) boost::beast::get_lowest_layer(self->stream_).close();
    });
    wake();
  }

 private:
  static constexpr std::size_t kFrameOverhead = 128;  // its header, and that of a TLS record of its own
  static constexpr std::size_t kFramingBytes = 64 * 1024;
  static constexpr std::chrono::seconds kHandshakeLimit{10};
  static constexpr std::chrono::seconds kSilenceLimit{30};
  static constexpr std::chrono::seconds kCloseLimit{5};
  static constexpr std::size_t kLongestReason = 123;  // RFC 6455, 5.5

  void shake_hands(const Request& request, std::string_view subprotocol) {
    namespace beast = boost::beast;
    namespace websocket = beast::websocket;
    beast::get_lowest_layer(stream_).expires_never();
    stream_.set_option(websocket::stream_base::timeout{kHandshakeLimit, kSilenceLimit, true});
    stream_.set_option(websocket::stream_base::decorator([subprotocol](websocket::response_type& response) {
      if (!subprotocol.empty()) {
        response.set(beast::http::field::sec_websocket_protocol,
                     beast::string_view(subprotocol.data(), subprotocol.size()));
      }
      if constexpr (std::is_same_v<Stream, TlsStream>)
        response.set("Strict-Transport-Security", "max-age=31536000");
    }));
    stream_.read_message_max(core_.options.maximum_frame_bytes);
    stream_.auto_fragment(false);
    bound_reading();
    stream_.control_callback([this](websocket::frame_type, beast::string_view payload) {
      budget().add(payload.size() + kFrameOverhead);
      if (!pings_.spend(core_.clock.now())) end(CloseCode::kPolicy, "a flood of control frames");
    });
    stream_.async_accept(request, [self = this->shared_from_this()](beast::error_code error) {
      if (error) return;
      self->id_ = self->join();
      self->read();
    });
  }

  [[nodiscard]] ReadBudget& budget() { return boost::beast::get_lowest_layer(stream_).rate_policy(); }

  /// A message of very many fragments, tiny or empty, is none that a client needs: the connection ends. No
  /// farewell, for nothing more is read.
  void bound_reading() {
    budget().when_spent([weak = this->weak_from_this()] {
      const auto self = weak.lock();
      if (!self) return;
      self->core_.hub.refuse(Refused::kOversized, self->peer_, "a message in too many fragments");
      boost::beast::get_lowest_layer(self->stream_).close();
    });
  }

  void read() {
    budget().renew(core_.options.maximum_frame_bytes + kFramingBytes);
    stream_.async_read(
        incoming_, [self = this->shared_from_this()](boost::beast::error_code error, std::size_t /*bytes*/) {
          self->on_read(error);
        });
  }

  void on_read(boost::beast::error_code error) {
    namespace websocket = boost::beast::websocket;
    if (error == websocket::error::message_too_big || error == websocket::error::buffer_overflow) {
      core_.hub.refuse(Refused::kOversized, peer_,
                       fmt::format("a message of over {} bytes", core_.options.maximum_frame_bytes));
    }
    if (error) return leave();
    const auto data = incoming_.cdata();
    const auto* begin = static_cast<const std::byte*>(data.data());
    if (stream_.got_text()) {
      core_.hub.on_text(id_, {reinterpret_cast<const char*>(begin), data.size()});
    } else {
      core_.hub.on_binary(id_, {begin, data.size()});
    }
    core_.wants_changed(core_.hub);
    incoming_.consume(incoming_.size());
    read();
  }

  /// The other side is gone, or will be: nothing more is sent.
  void leave() {
    last_resort_.cancel();
    if (id_ == 0) return;
    core_.hub.leave(id_);
    core_.wants_changed(core_.hub);
    id_ = 0;
  }

  void write() {
    if (is_writing_ || is_closed_) return;
    if (closing_) {
      is_closed_ = true;
      stream_.async_close(*closing_, [self = this->shared_from_this()](boost::beast::error_code) {
        self->last_resort_.cancel();
      });
      return;
    }
    auto next = core_.hub.next(id_);
    if (!next) return;
    outgoing_ = std::move(*next);
    is_writing_ = true;
    stream_.text(outgoing_.is_text);
    const std::array<boost::asio::const_buffer, 2> buffers{
        boost::asio::buffer(outgoing_.head),
        outgoing_.body ? boost::asio::buffer(outgoing_.body->data(), outgoing_.body->size())
                       : boost::asio::const_buffer()};
    stream_.async_write(
        buffers, [self = this->shared_from_this()](boost::beast::error_code error, std::size_t /*bytes*/) {
          self->is_writing_ = false;
          self->outgoing_ = {};
          if (!error) self->write();
        });
  }

  [[nodiscard]] ClientId join() {
    if (!json_topics_) return core_.hub.join(*this, role_, peer_);
    const ClientId id = core_.hub.join_json(*this, role_, peer_, *json_topics_);
    core_.wants_changed(core_.hub);
    return id;
  }

  ServerCore& core_;
  Seat seat_;
  boost::beast::websocket::stream<Stream> stream_;
  boost::asio::steady_timer last_resort_;
  boost::beast::flat_buffer incoming_;
  Outgoing outgoing_;
  Role role_;
  std::string peer_;
  ClientId id_ = 0;
  TokenBucket pings_{20.0, 60.0};
  std::optional<boost::beast::websocket::close_reason> closing_;
  std::optional<std::vector<std::string_view>> json_topics_;  ///< None: the subprotocol's.
  bool is_writing_ = false;
  bool is_woken_ = false;
  bool is_closed_ = false;
};

}  // namespace tonus::dashboard
