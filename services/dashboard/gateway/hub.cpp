#include "services/dashboard/gateway/hub.hpp"

#include <algorithm>
#include <spdlog/spdlog.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/rig.hpp"
#include "services/core/text.hpp"
#include "services/dashboard/gateway/derived_topics.hpp"
#include "services/dashboard/gateway/json_messages.hpp"

namespace tonus::dashboard {
namespace {

constexpr std::size_t kMaximumSubscriptions = 256;
constexpr std::size_t kMaximumClientChannels = 64;

constexpr std::array<const char*, static_cast<std::size_t>(Refused::kCount)> kRefusedNames{
    "connection", "malformed", "flood", "oversized", "forbidden", "slow"};

std::shared_ptr<const bus::Payload> as_payload(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return std::make_shared<const bus::Payload>(bytes.begin(), bytes.end());
}

std::string_view as_text(std::span<const std::byte> data) {
  return {reinterpret_cast<const char*>(data.data()), data.size()};
}

}  // namespace

const char* refused_name(Refused kind) { return kRefusedNames[static_cast<std::size_t>(kind)]; }

Hub::Hub(std::vector<OfferedTopic> topics, Options options, const Clock& clock,
         std::function<void(OperatorRequest)> ask)
    : topics_(std::move(topics)),
      options_(std::move(options)),
      clock_(clock),
      ask_(std::move(ask)),
      latest_(options_.latest) {}

std::pair<ClientId, Hub::Client&> Hub::add(ClientLink& link, Role role, const std::string& peer) {
  const ClientId id = ++last_client_;
  Client& client =
      clients_
          .emplace(id, Client{&link,
                              role,
                              peer,
                              clock_.now(),
                              Outbox(options_.outbox),
                              TokenBucket(options_.frames_per_second, options_.frames_burst),
                              {},
                              {},
                              TokenBucket(options_.malformed_per_second, options_.malformed_burst),
                              false,
                              false})
          .first->second;
  if (is_over_) dismiss(client);
  return {id, client};
}

ClientId Hub::join(ClientLink& link, Role role, const std::string& peer) {
  const auto [id, client] = add(link, role, peer);
  ServerInfo info{"tonus-dashboard", options_.session, options_.metadata};
  info.metadata.emplace_back("role", role_name(role));
  std::vector<Channel> channels;
  for (const auto& offered : topics_) channels.push_back(offered.channel);
  send_state(client, {server_info_text(info), nullptr, true});
  send_state(client, {advertise_text(channels), nullptr, true});
  return id;
}

ClientId Hub::join_json(ClientLink& link, Role role, const std::string& peer,
                        std::span<const std::string_view> wanted) {
  const auto [id, client] = add(link, role, peer);
  client.is_json = true;
  for (const std::string_view name : wanted) {
    const std::uint32_t channel = topic_named(name).channel.id;
    subscribe(id, client, {channel, channel});
  }
  return id;
}

void Hub::leave(ClientId id) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  thinned_before_ += found->second.outbox.thinned();
  clients_.erase(found);
  for (auto& [channel, listeners] : listeners_)
    std::erase_if(listeners, [id](const Listener& listener) { return listener.client == id; });
}

void Hub::dismiss_all() {
  is_over_ = true;
  for (auto& [id, client] : clients_) dismiss(client);
}

void Hub::dismiss(Client& client) {
  client.is_ending = true;
  client.link->end(CloseCode::kGoingAway, "the gateway ends");
}

void Hub::on_text(ClientId id, std::string_view text) {
  const auto found = clients_.find(id);
  if (found == clients_.end() || !may_speak(id, found->second)) return;
  if (found->second.is_json) return complain(found->second, "this WebSocket takes no messages");
  const auto saying = parse_client_text(text);
  if (!saying) return complain(found->second, saying.error().message);
  std::visit([&](const auto& what) { handle(id, found->second, what); }, *saying);
}

void Hub::on_binary(ClientId id, std::span<const std::byte> frame) {
  const auto found = clients_.find(id);
  if (found == clients_.end() || !may_speak(id, found->second)) return;
  Client& client = found->second;
  if (client.is_json) return complain(client, "this WebSocket takes no messages");
  const auto message = parse_client_binary(frame);
  if (!message) return complain(client, message.error().message);
  const auto channel = client.channels.find(message->channel);
  if (channel == client.channels.end())
    return complain(client, fmt::format("channel {} has not been advertised", message->channel));
  const ClientChannel& from = channel->second;
  if (from.topic != kRequestTopic || from.encoding != "json")
    return complain(client, fmt::format("topic '{}' in {} is not taken; only {} in json is", from.topic,
                                        from.encoding, kRequestTopic));
  take_request(client, message->data);
}

bool Hub::may_speak(ClientId /*id*/, Client& client) {
  if (client.is_ending) return false;
  if (client.frames.spend(clock_.now())) return true;
  end(client, Refused::kFlood, CloseCode::kPolicy,
      fmt::format("more than {:.0f} messages a second", options_.frames_per_second));
  return false;
}

void Hub::handle(ClientId id, Client& client, const Subscribe& saying) {
  for (const auto& subscription : saying.subscriptions) subscribe(id, client, subscription);
}

void Hub::subscribe(ClientId id, Client& client, const Subscription& wanted) {
  const OfferedTopic* offered = topic(wanted.channel);
  if (offered == nullptr) return complain(client, fmt::format("there is no channel {}", wanted.channel));
  if (client.subscriptions.contains(wanted.id))
    return complain(client, fmt::format("subscription {} already exists", wanted.id));
  if (client.subscriptions.size() >= kMaximumSubscriptions)
    return complain(client, fmt::format("at most {} subscriptions are allowed", kMaximumSubscriptions));
  client.subscriptions[wanted.id] = wanted.channel;
  listeners_[wanted.channel].push_back({id, wanted.id});
  for (const auto& message : latest_.of(wanted.channel)) send(client, wanted.id, *offered, message);
}

void Hub::handle(ClientId id, Client& client, const Unsubscribe& saying) {
  for (const auto subscription : saying.ids) {
    const auto known = client.subscriptions.find(subscription);
    if (known == client.subscriptions.end()) {
      complain(client, fmt::format("there is no subscription {}", subscription));
      continue;
    }
    std::erase_if(listeners_[known->second], [&](const Listener& listener) {
      return listener.client == id && listener.subscription == subscription;
    });
    client.subscriptions.erase(known);
    client.outbox.forget(subscription);
  }
}

void Hub::handle(ClientId /*id*/, Client& client, const ClientAdvertise& saying) {
  for (const auto& channel : saying.channels) {
    // Dashboards announce topics of their own, whether anybody takes them or not: nothing is said before use.
    if (client.channels.size() >= kMaximumClientChannels)
      return complain(client, fmt::format("at most {} channels are allowed", kMaximumClientChannels));
    client.channels[channel.id] = channel;
  }
}

void Hub::handle(ClientId /*id*/, Client& client, const ClientUnadvertise& saying) {
  for (const auto id : saying.ids) client.channels.erase(id);
}

void Hub::take_request(Client& client, std::span<const std::byte> data) {
  const Asker asker{client.role, "dashboard " + client.peer, options_.rig, clock_.utc_ns()};
  Id id{};
  std::string name;
  auto request = parse_request(as_text(data), asker, id, name);
  if (request) return ask_(std::move(*request));
  if (!name.empty() && !is_allowed(client.role, name)) {
    refuse(Refused::kForbidden, client.peer, request.error().message);
  } else if (id == kNoId) {
    return complain(client, request.error().message);
  } else {
    refuse(Refused::kMalformed, client.peer, request.error().message);
  }
  if (id != kNoId) on_reply({id, name, false, request.error().message, asker.name});
}

void Hub::complain(Client& client, const std::string& what) {
  refuse(Refused::kMalformed, client.peer, what);
  if (!client.malformed.spend(clock_.now())) {
    client.is_ending = true;
    client.link->end(CloseCode::kPolicy,
                     "too many messages that cannot be understood; the last one: " + what);
    return;
  }
  send_state(client,
             {client.is_json ? error_text(what) : status_text(StatusLevel::kError, what), nullptr, true});
}

std::optional<Outgoing> Hub::next(ClientId id) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return std::nullopt;
  return found->second.outbox.pop();
}

void Hub::on_bus_message(const PassedMessage& message) {
  const OfferedTopic* offered = topic(message.channel);
  if (offered == nullptr) return;
  if (offered->flow == Flow::kKept) latest_.put(message);
  note_results(*offered, message);
  fan_out(*offered, message);
  derive(*offered, message);
}

/// What the gateway makes of the message for Foxglove and Lichtblick.
void Hub::derive(const OfferedTopic& offered, const PassedMessage& message) {
  const std::string_view name = offered.channel.topic;
  if (name == topics::kTrialCommand.spec.name) {
    if (const auto command = bus::decode<v1::TrialCommand>(*message.payload))
      shoulder_ = contract::shoulder_of(command->program());
  } else if (name == topics::kEstimateCondition.spec.name) {
    const auto estimate = bus::decode<v1::Estimate>(*message.payload);
    if (!estimate) return;
    const OfferedTopic& scene = topic_named(kSceneTopic);
    const PassedMessage drawn{scene.channel.id, message.key, message.time_ns,
                              as_payload(ellipse_scene_json(*estimate, message.time_ns))};
    latest_.put(drawn);
    fan_out(scene, drawn);
  } else if (name == topics::kRigSamples.spec.name) {
    derive_hand(message);
  }
}

void Hub::derive_hand(const PassedMessage& message) {
  const OfferedTopic& hand = topic_named(kHandTopic);
  const auto listeners = listeners_.find(hand.channel.id);
  if (listeners == listeners_.end() || listeners->second.empty()) return;
  const auto block = bus::decode<v1::SampleBlock>(*message.payload);
  const auto rig = rig_description();
  if (!block || !rig || block->is_resent()) return;
  const auto geometry = contract::geometry_of(*rig);
  if (!geometry) return;
  if (const auto text = hand_json(*block, *geometry, shoulder_))
    fan_out(hand, {hand.channel.id, {}, message.time_ns, as_payload(*text)});
}

void Hub::note_results(const OfferedTopic& offered, const PassedMessage& message) {
  const std::string_view name = offered.channel.topic;
  if (name == topics::kTrialOutcome.spec.name) {
    latency_.note_outcome(message.key, message.time_ns);
  } else if (name == topics::kTrialVerdict.spec.name) {
    latency_.note_verdict(message.key, message.time_ns);
  } else if (name == topics::kEstimateCondition.spec.name) {
    const auto estimate = bus::decode<v1::Estimate>(*message.payload);
    if (!estimate) return;
    std::vector<Id> trials;
    for (const auto& range : estimate->trials())
      trials.push_back(trial_id(estimate->session_id(), range.attempt()));
    latency_.note_estimate(trials, message.time_ns);
  }
}

std::vector<PassedMessage> Hub::latest(std::string_view topic) const {
  return latest_.of(topic_named(topic).channel.id);
}

std::optional<v1::RigDescription> Hub::rig_description() const {
  std::optional<v1::RigDescription> found;
  for (const PassedMessage& message : latest(topics::kRigDescription.spec.name)) {
    const auto description = bus::decode<v1::RigDescription>(*message.payload);
    if (description && Id(description->rig_id()) == options_.rig) found = *description;
  }
  return found;
}

void Hub::on_reply(const OperatorReply& reply) { fan_out_json(kReplyTopic, reply_text(reply)); }

void Hub::fan_out_json(std::string_view name, const std::string& json) {
  const OfferedTopic& offered = topic_named(name);
  fan_out(offered, {offered.channel.id, {}, clock_.utc_ns(), as_payload(json)});
}

void Hub::fan_out(const OfferedTopic& offered, const PassedMessage& message) {
  const auto listeners = listeners_.find(message.channel);
  if (listeners == listeners_.end()) return;
  for (const Listener& listener : listeners->second)
    send(clients_.at(listener.client), listener.subscription, offered, message);
}

void Hub::send(Client& client, std::uint32_t subscription, const OfferedTopic& offered,
               const PassedMessage& message) {
  if (client.is_ending) return;
  Outgoing outgoing{client.is_json ? std::string() : message_head(subscription, message.time_ns),
                    client.is_json ? json_of(offered, message) : message.payload, client.is_json};
  if (!outgoing.body) return;
  if (offered.flow != Flow::kLive) return send_state(client, std::move(outgoing));
  client.outbox.push_live(subscription, std::move(outgoing), clock_.now());
  client.link->wake();
}

std::shared_ptr<const bus::Payload> Hub::json_of(const OfferedTopic& offered, const PassedMessage& message) {
  JsonBody& json = *message.json;
  if (json.is_made) return json.text;
  json.is_made = true;
  const auto text = json_message(offered.channel.topic, message.time_ns, *message.payload);
  if (text) {
    json.text = as_payload(*text);
  } else {
    refuse(Refused::kMalformed, "bus", fmt::format("{}: {}", offered.channel.topic, text.error().message));
  }
  return json.text;
}

std::string Hub::latest_json(std::span<const std::string_view> wanted) {
  std::vector<std::string> texts;
  for (const std::string_view name : wanted) {
    const OfferedTopic& offered = topic_named(name);
    for (const PassedMessage& message : latest_.of(offered.channel.id)) {
      if (const auto text = json_of(offered, message)) texts.emplace_back(as_text(*text));
    }
  }
  return json_list(texts);
}

void Hub::send_state(Client& client, Outgoing message) {
  if (client.is_ending) return;
  if (client.outbox.push_state(std::move(message))) return client.link->wake();
  end(client, Refused::kSlow, CloseCode::kTryAgain,
      fmt::format("too slow: {} messages ({} bytes) wait to be sent, and none of them may be left out",
                  client.outbox.waiting_messages(), client.outbox.waiting_bytes()));
  client.outbox.clear();
}

void Hub::end(Client& client, Refused kind, CloseCode code, const std::string& reason) {
  client.is_ending = true;
  refuse(kind, client.peer, reason);
  client.link->end(code, reason);
}

void Hub::refuse(Refused kind, const std::string& peer, const std::string& reason) {
  const auto index = static_cast<std::size_t>(kind);
  ++refused_[index];
  if (log_lines_.spend(clock_.now()))
    spdlog::warn("refused {} ({}): {}", shown(peer), kRefusedNames[index], shown(reason));
}

const OfferedTopic* Hub::topic(std::uint32_t channel) const {
  return channel >= 1 && channel <= topics_.size() ? &topics_[channel - 1] : nullptr;
}

const OfferedTopic& Hub::topic_named(std::string_view name) const {
  return *std::find_if(topics_.begin(), topics_.end(),
                       [&](const OfferedTopic& offered) { return offered.channel.topic == name; });
}

bool Hub::is_wanted(std::uint32_t channel) const {
  const auto has_listeners = [this](std::uint32_t one) {
    const auto listeners = listeners_.find(one);
    return listeners != listeners_.end() && !listeners->second.empty();
  };
  return has_listeners(channel) || (channel == topic_named(topics::kRigSamples.spec.name).channel.id &&
                                    has_listeners(topic_named(kHandTopic).channel.id));
}

std::size_t Hub::waiting_messages() const {
  std::size_t sum = 0;
  for (const auto& [id, client] : clients_) sum += client.outbox.waiting_messages();
  return sum;
}

std::uint64_t Hub::thinned() const {
  std::uint64_t sum = thinned_before_;
  for (const auto& [id, client] : clients_) sum += client.outbox.thinned();
  return sum;
}

}  // namespace tonus::dashboard
