#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "services/core/result.hpp"

namespace tonus {

/// The whole file. kNotFound or kIo names it and the reason.
[[nodiscard]] Result<std::string> read_text_file(const std::filesystem::path& path);

/// Writes beside `path` and renames: afterwards the file is whole or as it was before.
[[nodiscard]] Result<void> write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace tonus
