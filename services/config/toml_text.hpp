#pragma once

#include <string>
#include <string_view>
#include <toml++/toml.h>

#include "services/core/result.hpp"

namespace tonus::config {

/// The only call of the TOML parser. kInvalidArgument with "source:line: not TOML: reason", and for keys so
/// deep that the parser would exhaust the stack (check_toml_depth).
[[nodiscard]] Result<toml::table> parse_toml(std::string_view text, const std::string& source);

}  // namespace tonus::config
