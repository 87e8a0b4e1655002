#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "services/bus/bus.hpp"
#include "services/dashboard/gateway/frames.hpp"

/// What the gateway offers: every topic of the bus, and its own ones.
namespace tonus::dashboard {

/// How a topic is treated on its way to clients.
enum class Flow : std::uint8_t {
  kKept,  ///< State and results: none is left out; late joiners get the newest of each key.
  kOnce,  ///< Requests and replies: none is left out; nothing is kept.
  kLive,  ///< For eyes: a slow client gets fewer.
};

struct OfferedTopic {
  Channel channel;
  Flow flow = Flow::kOnce;
  bus::TopicSpec reading;  ///< How the gateway reads it from the bus. No name: the gateway's own.
};

/// Topics of the gateway itself, JSON.
inline constexpr char kStatusTopic[] = "gateway/status";
inline constexpr char kReplyTopic[] = "operator/reply";
/// For Foxglove and Lichtblick: derived_topics.hpp.
inline constexpr char kHandTopic[] = "hand/live";
inline constexpr char kSceneTopic[] = "estimate/scene";
/// What clients publish to ask for something, JSON.
inline constexpr char kRequestTopic[] = "operator/request";

/// All of idl/topics.hpp in its order, then kStatusTopic, kReplyTopic, kHandTopic and kSceneTopic. Ids begin
/// at 1. Live topics, and requests between others, are read best effort: whatever becomes of the gateway, no
/// writer waits for it.
[[nodiscard]] std::vector<OfferedTopic> offered_topics();

/// The text of the .idl file that defines a type of the contract, "tonus::v1::RigState"; empty for any other.
[[nodiscard]] std::string schema_text(const std::string& type_name);

}  // namespace tonus::dashboard
