#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tonus {

/// Text comes from people, files and other programs, and may be anything. What enters by the command line, a
/// file or a message is refused unless is_utf8(). Messages and archives have no other characters than
/// masked() leaves, as their generated code holds; what else leaves for a terminal, a log or a table goes
/// through shown().

/// Whether the text is UTF-8 (no surrogates, no overlong forms, nothing beyond U+10FFFF).
[[nodiscard]] bool is_utf8(std::string_view text);

/// The text with U+FFFD for each byte that is not UTF-8; as JSON and other formats need it.
[[nodiscard]] std::string as_utf8(std::string_view text);

/// As as_utf8(), and U+FFFD for each control character (line ends, escape codes, C1) and for the characters
/// that turn the direction of what follows: one line, which cannot steer a terminal or fake another line.
[[nodiscard]] std::string shown(std::string_view text);

/// What a text may hold: a line for a person, or a whole file with its line ends and tabs.
enum class TextKind : std::uint8_t { kLine, kFile };

/// The text with '?' for each byte of what shown() replaces, and spaces for the line ends and tabs of a line:
/// as long as before, for messages.
[[nodiscard]] std::string masked(std::string text, TextKind kind);

/// For a cell of a table that spreadsheets open: an apostrophe goes before a text that they would take for a
/// formula (it begins with = + - @, a tab or a carriage return).
[[nodiscard]] std::string as_cell(std::string_view text);

}  // namespace tonus
