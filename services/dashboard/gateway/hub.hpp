#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/clock.hpp"
#include "services/dashboard/gateway/access.hpp"
#include "services/dashboard/gateway/frames.hpp"
#include "services/dashboard/gateway/latest_values.hpp"
#include "services/dashboard/gateway/operator_request.hpp"
#include "services/dashboard/gateway/outbox.hpp"
#include "services/dashboard/gateway/result_latency.hpp"
#include "services/dashboard/gateway/token_bucket.hpp"
#include "services/dashboard/gateway/topic_table.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::dashboard {

/// Why a connection is ended; WebSocket close codes (RFC 6455, 7.4.1).
enum class CloseCode : std::uint16_t { kGoingAway = 1001, kPolicy = 1008, kTooBig = 1009, kTryAgain = 1013 };

/// A client's connection, as the hub sees it. Both calls only note what is to be done.
class ClientLink {
 public:
  virtual ~ClientLink() = default;
  virtual void wake() = 0;  ///< Something waits to be sent: Hub::next() has it.
  virtual void end(CloseCode code, const std::string& reason) = 0;
};

/// What was refused, counted by kind.
enum class Refused : std::uint8_t { kConnection, kMalformed, kFlood, kOversized, kForbidden, kSlow, kCount };

[[nodiscard]] const char* refused_name(Refused kind);

using ClientId = std::uint64_t;

/// Who is connected, what they subscribed to, and what goes to whom. No network and no bus; one thread.
class Hub {
 public:
  struct Options {
    Outbox::Limits outbox;
    LatestValues::Limits latest;
    double frames_per_second = 50.0;  ///< That a client may send; more is a flood.
    double frames_burst = 200.0;
    double malformed_per_second = 1.0 / 60.0;  ///< Frames that cannot be understood; with more the client has
    double malformed_burst = 8.0;              ///< to go.
    Id rig{};
    std::vector<std::pair<std::string, std::string>> metadata;  ///< For the server's info.
    std::string session;                                        ///< Of this start of the gateway.
  };

  /// `ask` is called with each request that is well-formed and allowed.
  Hub(std::vector<OfferedTopic> topics, Options options, const Clock& clock,
      std::function<void(OperatorRequest)> ask);

  /// `link` is used until leave().
  [[nodiscard]] ClientId join(ClientLink& link, Role role, const std::string& peer);
  /// The same for a client that only listens, to JSON (json_messages.hpp) of these topics: it is greeted by
  /// the newest message of each key.
  [[nodiscard]] ClientId join_json(ClientLink& link, Role role, const std::string& peer,
                                   std::span<const std::string_view> wanted);
  void leave(ClientId client);
  /// The gateway ends: each client is told so, whoever still joins too, and nothing more is sent.
  void dismiss_all();

  void on_text(ClientId client, std::string_view text);
  void on_binary(ClientId client, std::span<const std::byte> frame);

  /// The next message to send to a client.
  [[nodiscard]] std::optional<Outgoing> next(ClientId client);

  void on_bus_message(const PassedMessage& message);
  void on_reply(const OperatorReply& reply);

  /// Tells the subscribers of gateway/status how things are. `arrival_drops`: live messages that were left
  /// out before they reached the hub.
  void publish_status(std::uint64_t arrival_drops);

  /// Notes a refusal and logs it, unless very many are.
  void refuse(Refused kind, const std::string& peer, const std::string& reason);

  /// Whether anybody subscribes to a channel, or to what is made of it.
  [[nodiscard]] bool is_wanted(std::uint32_t channel) const;

  [[nodiscard]] const std::vector<OfferedTopic>& topics() const { return topics_; }
  [[nodiscard]] std::size_t clients() const { return clients_.size(); }
  [[nodiscard]] std::size_t waiting_messages() const;
  [[nodiscard]] std::uint64_t thinned() const;
  [[nodiscard]] std::uint64_t refused(Refused kind) const { return refused_[static_cast<std::size_t>(kind)]; }
  /// The newest message of each key of a topic, in the order of their coming.
  [[nodiscard]] std::vector<PassedMessage> latest(std::string_view topic) const;
  /// Of the gateway's rig, the newest.
  [[nodiscard]] std::optional<v1::RigDescription> rig_description() const;
  /// The newest of several topics as a JSON list. Messages that cannot be read are left out and counted.
  [[nodiscard]] std::string latest_json(std::span<const std::string_view> wanted);
  [[nodiscard]] const ResultLatency& latency() const { return latency_; }
  [[nodiscard]] std::string status_json(std::uint64_t arrival_drops) const;

 private:
  struct Client {
    ClientLink* link = nullptr;
    Role role = Role::kView;
    std::string peer;
    Clock::TimePoint joined;
    Outbox outbox;
    TokenBucket frames;
    std::map<std::uint32_t, std::uint32_t> subscriptions;  ///< Subscription to channel.
    std::map<std::uint32_t, ClientChannel> channels;       ///< That it publishes on.
    TokenBucket malformed;
    bool is_json = false;  ///< Is sent JSON, and says nothing.
    bool is_ending = false;
  };
  struct Listener {
    ClientId client = 0;
    std::uint32_t subscription = 0;
  };

  [[nodiscard]] std::pair<ClientId, Client&> add(ClientLink& link, Role role, const std::string& peer);
  [[nodiscard]] std::shared_ptr<const bus::Payload> json_of(const OfferedTopic& topic,
                                                            const PassedMessage& message);
  [[nodiscard]] const OfferedTopic* topic(std::uint32_t channel) const;
  [[nodiscard]] const OfferedTopic& topic_named(std::string_view name) const;
  [[nodiscard]] bool may_speak(ClientId id, Client& client);
  void handle(ClientId id, Client& client, const Subscribe& saying);
  void handle(ClientId id, Client& client, const Unsubscribe& saying);
  void handle(ClientId id, Client& client, const ClientAdvertise& saying);
  void handle(ClientId id, Client& client, const ClientUnadvertise& saying);
  void subscribe(ClientId id, Client& client, const Subscription& subscription);
  void take_request(Client& client, std::span<const std::byte> data);
  void complain(Client& client, const std::string& what);
  void send_state(Client& client, Outgoing message);
  void send(Client& client, std::uint32_t subscription, const OfferedTopic& topic,
            const PassedMessage& message);
  void fan_out(const OfferedTopic& topic, const PassedMessage& message);
  void fan_out_json(std::string_view topic, const std::string& json);
  void derive(const OfferedTopic& topic, const PassedMessage& message);
  void derive_hand(const PassedMessage& message);
  void note_results(const OfferedTopic& topic, const PassedMessage& message);
  static void dismiss(Client& client);
  void end(Client& client, Refused kind, CloseCode code, const std::string& reason);

  std::vector<OfferedTopic> topics_;
  Options options_;
  const Clock& clock_;
  std::function<void(OperatorRequest)> ask_;
  LatestValues latest_;
  ResultLatency latency_;
  ShoulderPose shoulder_;  ///< Of the newest trial.
  std::map<ClientId, Client> clients_;
  std::map<std::uint32_t, std::vector<Listener>> listeners_;  ///< Of each channel.
  ClientId last_client_ = 0;
  bool is_over_ = false;              ///< dismiss_all() was called.
  std::uint64_t thinned_before_ = 0;  ///< For clients that have left.
  std::array<std::uint64_t, static_cast<std::size_t>(Refused::kCount)> refused_{};
  TokenBucket log_lines_{5.0, 50.0};
};

}  // namespace tonus::dashboard
