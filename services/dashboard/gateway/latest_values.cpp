#include "services/dashboard/gateway/latest_values.hpp"

namespace tonus::dashboard {

void LatestValues::put(const PassedMessage& message) {
  Topic& topic = topics_[message.channel];
  if (const auto known = topic.by_key.find(message.key); known != topic.by_key.end()) {
    topic.bytes -= known->second->payload->size();
    topic.in_order.erase(known->second);
    topic.by_key.erase(known);
  }
  topic.bytes += message.payload->size();
  topic.in_order.push_back(message);
  topic.by_key[message.key] = std::prev(topic.in_order.end());
  while (topic.in_order.size() > 1 &&
         (topic.in_order.size() > limits_.messages || topic.bytes > limits_.bytes)) {
    topic.bytes -= topic.in_order.front().payload->size();
    topic.by_key.erase(topic.in_order.front().key);
    topic.in_order.pop_front();
    ++forgotten_;
  }
}

std::vector<PassedMessage> LatestValues::of(std::uint32_t channel) const {
  const auto topic = topics_.find(channel);
  if (topic == topics_.end()) return {};
  return {topic->second.in_order.begin(), topic->second.in_order.end()};
}

std::size_t LatestValues::messages() const {
  std::size_t sum = 0;
  for (const auto& [channel, topic] : topics_) sum += topic.in_order.size();
  return sum;
}

std::size_t LatestValues::bytes() const {
  std::size_t sum = 0;
  for (const auto& [channel, topic] : topics_) sum += topic.bytes;
  return sum;
}

}  // namespace tonus::dashboard
