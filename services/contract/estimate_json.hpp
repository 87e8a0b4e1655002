#pragma once

#include <nlohmann/json_fwd.hpp>

#include <idl/estimate.h>

/// The one JSON of an estimate: of `tonus identify --json` and `run --json`, of the gateway, of Python.
namespace tonus::contract {

/// One object, matrices row by row, in S. Units are in the keys; a one-axis rig's are in `units`, because its
/// keys keep the names of the two-axis ones. What is not known is null. An undetermined estimate has no
/// numbers: M_kg, B_Ns_per_m, K_N_per_m, X0_m, std, ci95 and what belongs to them are absent.
[[nodiscard]] nlohmann::json json_of(const v1::Estimate& estimate);

}  // namespace tonus::contract
