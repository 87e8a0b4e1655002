#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tonus::dashboard::testing {

/// What of a JSON value departs from a schema of an OpenAPI document, with its place; empty: nothing. Of JSON
/// Schema what that document uses: $ref, oneOf, type, enum, required, properties, additionalProperties false,
/// items, minItems, maxItems. Another keyword that restricts is an error of the schema.
[[nodiscard]] std::string violation(const nlohmann::json& document, const nlohmann::json& schema,
                                    const nlohmann::json& value, const std::string& place = "");

}  // namespace tonus::dashboard::testing
