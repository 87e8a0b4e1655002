#include "services/bus/topic_check.hpp"

#include <string>

#include "services/bus/payload.hpp"

namespace tonus::bus {
namespace {

constexpr int kMaximumDepth = 4096;

Error topic_error(const TopicSpec& topic, const std::string& text) {
  return fail(ErrorCode::kInvalidArgument, "topic '" + std::string(topic.name) + "': " + text);
}

}  // namespace

Result<void> check_topic(const TopicSpec& topic) {
  if (topic.name.empty() || topic.type_name.empty())
    return topic_error(topic, "needs a name and a type name");
  const Qos& qos = topic.qos;
  if (qos.depth < 1 || qos.depth > kMaximumDepth) {
    return topic_error(topic, "depth: " + std::to_string(qos.depth) + " is not allowed; expected 1 to " +
                                  std::to_string(kMaximumDepth));
  }
  if (topic.max_payload_bytes < kMinimumPayloadBytes) {
    return topic_error(topic, "payload limit: " + std::to_string(topic.max_payload_bytes) +
                                  " bytes are not allowed; expected at least " +
                                  std::to_string(kMinimumPayloadBytes));
  }
  for (const auto& [what, time] :
       {std::pair{"deadline", qos.deadline}, std::pair{"liveliness lease", qos.liveliness_lease},
        std::pair{"blocking time", qos.max_blocking}}) {
    if (time.count() < 0) {
      return topic_error(topic, std::string(what) + ": " + std::to_string(time.count()) +
                                    " ms is not allowed; expected 0 ms or more");
    }
  }
  return {};
}

}  // namespace tonus::bus
