#include "services/core/text.hpp"

#include <algorithm>
#include <cstddef>

namespace tonus {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;  ///< 0: the text does not begin with a character.
};

Character first_of(std::string_view text) {
  const auto lead = static_cast<std::uint8_t>(text[0]);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {};
  std::uint32_t code = lead & (0xFFU >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    const auto byte = static_cast<std::uint8_t>(text[i]);
    if ((byte & 0xC0U) != 0x80U) return {};
    code = code << 6U | (byte & 0x3FU);
  }
  const bool is_overlong = (bytes == 3 && code < 0x800) || (bytes == 4 && code < 0x10000);
  if (is_overlong || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF)) return {};
  return {code, bytes};
}

bool is_steering(std::uint32_t code) {
  const bool is_control = code < 0x20 || (code >= 0x7F && code < 0xA0);
  const bool is_line_end = code == 0x2028 || code == 0x2029;
  const bool is_direction = code == 0x200E || code == 0x200F || (code >= 0x202A && code <= 0x202E) ||
                            (code >= 0x2066 && code <= 0x2069);
  return is_control || is_line_end || is_direction;
}

template <typename Replaces>
std::string replaced(std::string_view text, const Replaces& replaces) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const Character character = first_of(text);
    const std::size_t bytes = character.bytes == 0 ? 1 : character.bytes;
    result += character.bytes == 0 || replaces(character.code) ? kReplacement : text.substr(0, bytes);
    text.remove_prefix(bytes);
  }
  return result;
}

}  // namespace

std::string masked(std::string text, TextKind kind) {
  std::size_t place = 0;
  while (place < text.size()) {
    const Character character = first_of(std::string_view(text).substr(place));
    const std::size_t bytes = character.bytes == 0 ? 1 : character.bytes;
    const bool is_layout = character.code == '\n' || character.code == '\t' || character.code == '\r';
    const bool is_kept =
        character.bytes != 0 && (!is_steering(character.code) || (kind == TextKind::kFile && is_layout));
    const auto begin = text.begin() + static_cast<std::ptrdiff_t>(place);
    if (!is_kept) std::fill_n(begin, bytes, is_layout && character.bytes != 0 ? ' ' : '?');
    place += bytes;
  }
  return text;
}

std::string as_cell(std::string_view text) {
  constexpr std::string_view kFormula = "=+-@\t\r";
  const bool is_formula = !text.empty() && kFormula.find(text.front()) != std::string_view::npos;
  return (is_formula ? "'" : "") + std::string(text);
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t bytes = first_of(text).bytes;
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

std::string as_utf8(std::string_view text) {
  return replaced(text, [](std::uint32_t) { return false; });
}

std::string shown(std::string_view text) { return replaced(text, is_steering); }

}  // namespace tonus
