#include "services/core/passwords.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace tonus {
namespace {

constexpr std::string_view kHidden = "***";
constexpr auto npos = std::string_view::npos;

bool ends_value(char c) { return c == '&' || std::isspace(static_cast<unsigned char>(c)) != 0; }

/// Of user:PASSWORD@ in URLs. A password may hold any character, '@' and quotes included: it ends at the last
/// '@' of its line.
std::string hide_in_urls(std::string_view line) {
  std::string shown;
  for (std::size_t scheme = line.find("://"); scheme != npos; scheme = line.find("://")) {
    const std::size_t user_end = std::min(line.find_first_of(":/@ \t", scheme + 3), line.size());
    const std::size_t at = line.rfind('@');
    shown += line.substr(0, user_end);
    if (user_end < line.size() && line[user_end] == ':' && at != npos && at > user_end) {
      shown += ':';
      shown += kHidden;
      line.remove_prefix(at);
      break;
    }
    line.remove_prefix(user_end);
  }
  return shown.append(line);
}

/// Length of the value that `text` begins with: in single quotes with what they hold, else up to '&', a
/// space, or the quote that closes what it stands in.
std::size_t value_length(std::string_view text) {
  const auto is_end = [&text](std::size_t place) { return place >= text.size() || ends_value(text[place]); };
  const bool is_quoted = text.starts_with('\'');
  for (std::size_t place = is_quoted ? 1 : 0; place < text.size(); ++place) {
    const char c = text[place];
    if (is_quoted) {
      if (c == '\\') {
        ++place;
      } else if (c == '\'' && (is_end(place + 1) || text[place + 1] == '"')) {
        return place + 1;
      }
    } else if (ends_value(c) || ((c == '"' || c == '\'') && is_end(place + 1))) {
      return place;
    }
  }
  return text.size();
}

/// Of password=PASSWORD, in any case.
std::string hide_parameters(std::string_view line) {
  constexpr std::string_view kName = "password";
  const auto same = [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; };
  std::string shown;
  while (true) {
    const auto found = std::search(line.begin(), line.end(), kName.begin(), kName.end(), same);
    auto place = static_cast<std::size_t>(found - line.begin());
    if (place == line.size()) return shown.append(line);
    place = std::min(line.find_first_not_of(" \t", place + kName.size()), line.size());
    if (place < line.size() && line[place] == '=') {
      place = std::min(line.find_first_not_of(" \t", place + 1), line.size());
      shown.append(line.substr(0, place));
      line.remove_prefix(place);
      const std::size_t length = value_length(line);
      if (length > 0) shown += kHidden;
      line.remove_prefix(length);
    } else {
      shown.append(line.substr(0, place));
      line.remove_prefix(place);
    }
  }
}

}  // namespace

std::string without_passwords(const std::string& text) {
  std::string shown;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    shown += hide_parameters(hide_in_urls(rest.substr(0, end)));
    rest.remove_prefix(end);
    if (rest.empty()) break;
    shown += '\n';
    rest.remove_prefix(1);
  }
  return shown;
}

}  // namespace tonus
