#pragma once

#include <string>
#include <string_view>

namespace tonus {

/// Text comes from people, files and other programs, and may be anything. What is refused at an entrance is
/// asked with is_utf8(); what leaves for a terminal, a log or a table goes through shown().

/// Whether the text is UTF-8 (no surrogates, no overlong forms, nothing beyond U+10FFFF).
[[nodiscard]] bool is_utf8(std::string_view text);

/// The text with U+FFFD for each byte that is not UTF-8; as JSON and other formats need it.
[[nodiscard]] std::string as_utf8(std::string_view text);

/// As as_utf8(), and U+FFFD for each control character (line ends, escape codes, C1) and for the characters
/// that turn the direction of what follows: one line, which cannot steer a terminal or fake another line.
[[nodiscard]] std::string shown(std::string_view text);

}  // namespace tonus
