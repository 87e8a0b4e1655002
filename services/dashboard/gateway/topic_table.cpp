#include "services/dashboard/gateway/topic_table.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "idl/topics.hpp"
#include "services/dashboard/gateway/derived_topics.hpp"
#include "services/dashboard/gateway/idl_texts.hpp"

namespace tonus::dashboard {
namespace {

// Lichtblick reads JSON schemas only where every object, those in lists too, names its properties.
constexpr char kStatusSchema[] = R"({
  "type": "object",
  "title": "State of the gateway, once a second",
  "properties": {
    "utc_ns": {"type": "integer"},
    "clients": {
      "type": "array",
      "items": {
        "type": "object",
        "properties": {
          "id": {"type": "integer"},
          "peer": {"type": "string"},
          "role": {"type": "string", "description": "view or operate"},
          "connected_s": {"type": "number"},
          "subscriptions": {"type": "integer"},
          "sent": {"type": "integer"},
          "thinned": {"type": "integer"},
          "waiting_messages": {"type": "integer"},
          "waiting_bytes": {"type": "integer"}
        }
      }
    },
    "thinned": {"type": "integer", "description": "live messages left out for slow clients"},
    "arrival_drops": {"type": "integer", "description": "live messages left out before they reached any client"},
    "kept_messages": {"type": "integer"},
    "kept_bytes": {"type": "integer"},
    "forgotten": {"type": "integer", "description": "kept messages that had to make room"},
    "refused": {
      "type": "object",
      "properties": {
        "connection": {"type": "integer"},
        "malformed": {"type": "integer"},
        "flood": {"type": "integer"},
        "oversized": {"type": "integer"},
        "forbidden": {"type": "integer"},
        "slow": {"type": "integer"}
      }
    }
  }
})";

constexpr char kReplySchema[] = R"({
  "type": "object",
  "title": "Answer to an operator's request",
  "properties": {
    "request_id": {"type": "string"},
    "request": {"type": "string"},
    "is_done": {"type": "boolean"},
    "message": {"type": "string"},
    "requested_by": {"type": "string"}
  }
})";

Flow flow_of(const bus::TopicSpec& spec) {
  constexpr std::array<std::string_view, 6> kForEyes{
      topics::kRigSamples.spec.name,   topics::kRigAuxiliary.spec.name, topics::kRigLease.spec.name,
      topics::kEstimateLive.spec.name, topics::kClockProbe.spec.name,   topics::kClockEcho.spec.name};
  if (std::find(kForEyes.begin(), kForEyes.end(), spec.name) != kForEyes.end()) return Flow::kLive;
  return spec.qos.durability == bus::Durability::kTransientLocal ? Flow::kKept : Flow::kOnce;
}

/// Only state, results and replies are worth that anybody waits for the gateway's acknowledgement.
bus::TopicSpec reading_of(bus::TopicSpec spec, Flow flow) {
  const bool is_reply =
      spec.name == topics::kSessionReply.spec.name || spec.name == topics::kRigReply.spec.name;
  if (flow == Flow::kKept || is_reply) return spec;
  spec.qos.reliable = false;
  spec.qos.history = bus::History::kKeepLast;
  spec.qos.depth = 256;
  return spec;
}

Channel own_channel(const char* topic, const char* schema_name, const char* schema) {
  return {0, topic, "json", schema_name, schema, "jsonschema"};
}

}  // namespace

std::string schema_text(const std::string& type_name) {
  const auto name = type_name.substr(type_name.rfind(':') + 1);
  for (const std::string_view text : kIdlTexts) {
    if (text.find("@final struct " + name + " {") != std::string_view::npos) return std::string(text);
  }
  return {};
}

std::vector<OfferedTopic> offered_topics() {
  std::vector<OfferedTopic> all;
  for (const bus::TopicSpec& spec : topics::kAll) {
    const std::string type(spec.type_name);
    const Flow flow = flow_of(spec);
    all.push_back({{0, std::string(spec.name), "cdr", type, schema_text(type), "omgidl"},
                   flow,
                   reading_of(spec, flow)});
  }
  all.push_back({own_channel(kStatusTopic, "tonus.GatewayStatus", kStatusSchema), Flow::kLive, {}});
  all.push_back({own_channel(kReplyTopic, "tonus.OperatorReply", kReplySchema), Flow::kOnce, {}});
  all.push_back({own_channel(kHandTopic, "tonus.Hand", kHandSchema), Flow::kLive, {}});
  all.push_back({own_channel(kSceneTopic, "foxglove.SceneUpdate", kSceneSchema), Flow::kKept, {}});
  std::uint32_t id = 0;
  for (auto& topic : all) topic.channel.id = ++id;
  return all;
}

}  // namespace tonus::dashboard
