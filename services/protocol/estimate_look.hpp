#pragma once

#include "services/protocol/stop_rule.hpp"

#include <idl/estimate.h>

namespace tonus::protocol {

/// What the stopping rule asks of an estimate.
[[nodiscard]] Look look_at(const v1::Estimate& estimate);

}  // namespace tonus::protocol
