#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "services/protocol/plan.hpp"
#include "services/protocol/protocol.hpp"
#include "services/protocol/rig_facts.hpp"

namespace tonus::protocol {

/// What a protocol would do with a seed, without anything moving.
struct DryRun {
  Plan plan;
  double duration = 0.0;  ///< s, expected if no trial has to be repeated.
  Extremes extremes;
};

/// kInvalidArgument where the rig cannot run it, or where it is a study (its parts can be asked for one by
/// one).
[[nodiscard]] Result<DryRun> dry_run(const Protocol& protocol, const RigFacts& facts, std::uint64_t seed);

/// Tables for a terminal: the extremes against their limits, the sets, and every trial in order.
[[nodiscard]] std::string to_text(const DryRun& run, const Protocol& protocol);

}  // namespace tonus::protocol
