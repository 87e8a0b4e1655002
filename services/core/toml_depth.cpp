#include "services/core/toml_depth.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

namespace tonus {
namespace {

constexpr int kMostParts = 16;

/// The characters of a string that begins at `text`, its quotes included; an open one ends with its line.
std::size_t string_length(std::string_view text) {
  const char quote = text.front();
  const std::string three(3, quote);
  if (text.starts_with(three)) {
    const std::size_t end = text.find(three, three.size());
    return end == std::string_view::npos ? text.size() : end + three.size();
  }
  std::size_t place = 1;
  while (place < text.size() && text[place] != quote && text[place] != '\n')
    place += quote == '"' && text[place] == '\\' ? 2 : 1;
  return std::min(place + 1, text.size());
}

}  // namespace

Result<void> check_toml_depth(std::string_view text, const std::string& source) {
  int line = 1;
  int dots = 0;
  while (!text.empty()) {
    const char c = text.front();
    std::size_t length = 1;
    if (c == '"' || c == '\'') {
      length = string_length(text);
    } else if (c == '#') {
      length = std::min(text.find('\n'), text.size());
    } else if (c == '.') {
      ++dots;
    } else if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) {
      dots = 0;  // a key ends
    }
    if (dots >= kMostParts) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}:{}: a key of more than {} parts is not allowed; expected fewer", source,
                              line, kMostParts));
    }
    line +=
        static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(length), '\n'));
    text.remove_prefix(length);
  }
  return {};
}

}  // namespace tonus
