#include "tests/unit/services/dashboard/json_schema.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace tonus::dashboard::testing {
namespace {

using nlohmann::json;

bool has_type(const json& value, const std::string& type) {
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "array") return value.is_array();
  if (type == "object") return value.is_object();
  return type == "null" && value.is_null();
}

bool has_one_type(const json& value, const json& types) {
  if (types.is_string()) return has_type(value, types.get<std::string>());
  return std::any_of(types.begin(), types.end(), [&](const json& type) { return has_type(value, type); });
}

std::string unknown_keyword(const json& schema) {
  constexpr std::array<std::string_view, 14> kKnown{
      "$ref",  "oneOf",    "type",     "enum",        "required", "properties", "additionalProperties",
      "items", "minItems", "maxItems", "description", "pattern",  "format",     "example"};
  for (const auto& [keyword, what] : schema.items()) {
    if (std::find(kKnown.begin(), kKnown.end(), keyword) == kKnown.end()) return keyword;
  }
  return {};
}

std::string object_violation(const json& document, const json& schema, const json& value,
                             const std::string& place) {
  for (const json& name : schema.value("required", json::array())) {
    if (!value.contains(name)) return place + "/" + name.get<std::string>() + ": is missing";
  }
  const json properties = schema.value("properties", json::object());
  for (const auto& [name, member] : value.items()) {
    if (properties.contains(name)) {
      if (auto found = violation(document, properties[name], member, place + "/" + name); !found.empty())
        return found;
    } else if (!schema.value("additionalProperties", true)) {
      return place + "/" + name + ": is not described";
    }
  }
  return {};
}

std::string array_violation(const json& document, const json& schema, const json& value,
                            const std::string& place) {
  if (value.size() < schema.value("minItems", std::size_t{0}) ||
      value.size() > schema.value("maxItems", value.size()))
    return place + ": has " + std::to_string(value.size()) + " items";
  for (std::size_t i = 0; schema.contains("items") && i < value.size(); ++i) {
    if (auto found = violation(document, schema["items"], value[i], place + "/" + std::to_string(i));
        !found.empty())
      return found;
  }
  return {};
}

}  // namespace

std::string violation(const json& document, const json& schema, const json& value, const std::string& place) {
  if (const auto keyword = unknown_keyword(schema); !keyword.empty())
    return place + ": keyword " + keyword + " is not known to this test";
  if (schema.contains("$ref"))
    return violation(document, document.at(json::json_pointer(schema["$ref"].get<std::string>().substr(1))),
                     value, place);
  if (schema.contains("oneOf")) {
    const auto fits = std::count_if(schema["oneOf"].begin(), schema["oneOf"].end(), [&](const json& one) {
      return violation(document, one, value, place).empty();
    });
    return fits == 1 ? std::string() : place + ": fits " + std::to_string(fits) + " of oneOf";
  }
  if (schema.contains("type") && !has_one_type(value, schema["type"]))
    return place + ": " + value.dump() + " is not " + schema["type"].dump();
  if (schema.contains("enum") &&
      std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
    return place + ": " + value.dump() + " is not of " + schema["enum"].dump();
  if (value.is_object()) return object_violation(document, schema, value, place);
  if (value.is_array()) return array_violation(document, schema, value, place);
  return {};
}

}  // namespace tonus::dashboard::testing
