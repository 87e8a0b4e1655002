#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include <idl/session.h>

/// How far a session's condition is, as a person reads it, and as programs do.
namespace tonus::cli {

/// One line: "reference: 12 trials, at most 16; half-width of stiffness 5.6 %, goal 5 %".
[[nodiscard]] std::string condition_text(const v1::ConditionProgress& condition);

/// `precision` is null while there is none.
[[nodiscard]] nlohmann::json condition_json(const v1::ConditionProgress& condition);

}  // namespace tonus::cli
