#pragma once

#include <string>
#include <string_view>

#include "services/core/result.hpp"

namespace tonus {

/// kInvalidArgument where a key of a TOML text has more parts (a.b.c has three) than any file of ours: the
/// parser makes a table of each part, and takes them apart again by recursion, so that a long enough key
/// exhausts the stack. To be asked before the text is parsed; says nothing else about it.
[[nodiscard]] Result<void> check_toml_depth(std::string_view text, const std::string& source);

}  // namespace tonus
