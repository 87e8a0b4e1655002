#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "services/core/result.hpp"

namespace tonus::recording {

/// The whole file, without a byte-order mark. kNotFound or kIo, with the path and the system's reason.
[[nodiscard]] Result<std::string> read_text(const std::filesystem::path& path);

/// Creates a file and waits until its content is on the disk. kIo.
[[nodiscard]] Result<void> write_text(const std::filesystem::path& path, std::string_view text);

/// Appends the shortest decimal text that reads back as the same double; whole numbers without exponent.
void append_number(std::string& text, double value);

}  // namespace tonus::recording
