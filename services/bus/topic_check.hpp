#pragma once

#include "services/bus/bus.hpp"

namespace tonus::bus {

/// kInvalidArgument when a carrier could not keep what the topic asks: no name, depth not 1 to 4096
/// (histories of tens of thousands collapse), a payload limit that has no room for header and key, a negative
/// time.
[[nodiscard]] Result<void> check_topic(const TopicSpec& topic);

}  // namespace tonus::bus
