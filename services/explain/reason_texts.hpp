#pragma once

#include <span>

#include "services/explain/explanation.hpp"

/// The tables, a file each.
namespace tonus::explain {

[[nodiscard]] std::span<const Explanation> verdict_reasons();
[[nodiscard]] std::span<const Explanation> estimate_reasons();
[[nodiscard]] std::span<const Explanation> fault_reasons();
[[nodiscard]] std::span<const Explanation> hold_reasons();
[[nodiscard]] std::span<const Explanation> trial_ends();

}  // namespace tonus::explain
