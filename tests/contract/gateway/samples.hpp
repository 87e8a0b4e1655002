#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "services/bus/bus.hpp"

namespace tonus::testing {

/// A message with something in every list and text, and what a decoder has to find in it: values by path,
/// "samples.0.flags"; numbers and texts as text. The last member is always among them.
struct SampleMessage {
  bus::TopicSpec topic;
  bus::Payload payload;
  nlohmann::json expected;
};

/// One for each topic of idl/topics.hpp.
[[nodiscard]] std::vector<SampleMessage> sample_messages();

}  // namespace tonus::testing
