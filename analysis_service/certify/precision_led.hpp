#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

#include "analysis_service/certify/drawn_session.hpp"
#include "analysis_service/impedance/identification.hpp"
#include "services/protocol/stop_rule.hpp"

namespace tonus::certify {

/// What the stopping rule asks of an estimate. The scheduler reads the same from a message.
[[nodiscard]] protocol::Look look_at(const impedance::Estimate& estimate, std::size_t trials);

/// A condition that ends by the rule: `design.trials` counts for nothing.
struct LedDesign {
  Design design;
  Setting setting;
  protocol::StopWhen rule;
  impedance::Method method = impedance::Method::kRefined;
  bool starts_at_limits = false;  ///< As after conditions whose drive was raised to the rule's limits.
};

struct LedCondition {
  protocol::LookEnd end = protocol::LookEnd::kGoesOn;
  std::size_t trials = 0;
  protocol::Look look;           ///< The last one.
  impedance::Estimate estimate;  ///< The last one.
  double entropy = 0.0;          ///< bits, mean of the directions' choices.
  double least_entropy = 0.0;    ///< bits
  protocol::Drive drive;         ///< Of the last trial.
};

/// Runs one condition trial by trial, as a scheduler would: directions drawn, each estimate from
/// `rule.trials_least` trials on looked at, the drive raised within the rule. Same seed, same condition.
[[nodiscard]] LedCondition simulate_led(const Truth& truth, const LedDesign& led, std::uint64_t seed);

}  // namespace tonus::certify
