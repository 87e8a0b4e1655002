#include "services/config/toml_text.hpp"

#include <spdlog/fmt/fmt.h>

#include "services/core/text.hpp"
#include "services/core/toml_depth.hpp"

namespace tonus::config {

Result<toml::table> parse_toml(std::string_view text, const std::string& source) {
  TONUS_TRY(check_toml_depth(text, source));
  try {
    return toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("{}:{}: not TOML: {}", source, error.source().begin.line, shown(error.description())));
  }
}

}  // namespace tonus::config
