#pragma once

#include <nlohmann/json_fwd.hpp>

#include "services/core/result.hpp"

#include <idl/session.h>

/// A subject's facts as JSON: keys are the names of the fields in idl/session.idl, with their units.
namespace tonus::contract {

/// Numbers that are not known are null, texts empty.
[[nodiscard]] nlohmann::json message_json(const v1::SubjectFacts& facts);

/// What a person or program states of a subject: one object. What is left out, or null, is not known.
/// kInvalidArgument names the key that is none, or whose value has another type; which values make sense is
/// not checked here.
[[nodiscard]] Result<v1::SubjectFacts> subject_facts_of(const nlohmann::json& object);

}  // namespace tonus::contract
