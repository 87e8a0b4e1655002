#pragma once

#include <string>

namespace tonus {

/// A value of nlohmann::json as text, whatever bytes are in it: its own dump() throws at what is not UTF-8.
template <typename Json>
[[nodiscard]] std::string json_text(const Json& json, int indent = 1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tonus
