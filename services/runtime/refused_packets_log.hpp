#pragma once

#include "services/core/clock.hpp"

namespace tonus::runtime {

/// Says in the log how many malformed packets the bus has dropped since it last said so, at most every ten
/// seconds. To be called now and then, from any thread.
void log_refused_packets(const Clock& clock);

}  // namespace tonus::runtime
