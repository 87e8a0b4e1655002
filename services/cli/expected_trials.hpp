#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/protocol/plan.hpp"
#include "services/protocol/protocol.hpp"
#include "services/simulation/profile.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::cli {

/// Trials that the conditions of a precision-led protocol are expected to take, in the plan's order.
struct ExpectedTrials {
  std::string from;             ///< What they rest on, for a person.
  std::vector<double> trials;   ///< Mean; not a number: not known.
  std::vector<double> reached;  ///< Share of conditions that reach their goals; not a number: not known.
};

/// By simulation: the profile's subject, sensors, drift and tremor on rigs drawn as `tonus certify` draws
/// them, trial by trial with the protocol's own rule. Without bias, reflex and raised drive. Same seed, same
/// numbers.
[[nodiscard]] ExpectedTrials expected_by_simulation(const protocol::Protocol& protocol,
                                                    const protocol::Plan& plan,
                                                    const simulation::Profile& profile, std::uint64_t seed);

/// From an earlier session's estimates by the rule's method at postures of the same name: half-widths fall
/// with the root of the trials and with the amplitude, as far as that was commanded alike there.
[[nodiscard]] ExpectedTrials expected_from(const protocol::Protocol& protocol, const protocol::Plan& plan,
                                           const store::Session& session);

/// A table for a terminal, and what the session takes in all.
[[nodiscard]] std::string to_text(const ExpectedTrials& expected, const protocol::Protocol& protocol,
                                  const protocol::Plan& plan);

}  // namespace tonus::cli
