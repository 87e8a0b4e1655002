#pragma once

#include <nlohmann/json_fwd.hpp>

#include <idl/estimate.h>
#include <idl/rig.h>
#include <idl/session.h>
#include <idl/trial.h>

/// Messages of the bus as JSON: one object each, its keys the names of the fields in idl/, with their units.
/// Ids are hexadecimal; enumerations have the names of names.hpp; what is not a finite number is null. An
/// estimate has the keys of estimate_json.hpp, and its ids.
namespace tonus::contract {

[[nodiscard]] nlohmann::json message_json(const v1::Estimate& estimate);
[[nodiscard]] nlohmann::json message_json(const v1::TrialVerdict& verdict);
[[nodiscard]] nlohmann::json message_json(const v1::TrialReview& review);
[[nodiscard]] nlohmann::json message_json(const v1::TrialProgram& program);
[[nodiscard]] nlohmann::json message_json(const v1::TrialOutcome& outcome);
[[nodiscard]] nlohmann::json message_json(const v1::SessionPlan& plan);
[[nodiscard]] nlohmann::json message_json(const v1::SessionState& state);
[[nodiscard]] nlohmann::json message_json(const v1::SessionNote& note);
[[nodiscard]] nlohmann::json message_json(const v1::RigState& state);
[[nodiscard]] nlohmann::json message_json(const v1::RigDescription& description);

}  // namespace tonus::contract
