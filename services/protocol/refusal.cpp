#include "services/protocol/refusal.hpp"

#include <cctype>
#include <charconv>
#include <string_view>

namespace tonus::protocol {
namespace {

bool is_of_key(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '[' || c == ']';
}

/// What a message begins with, if that is a key: one that is refused, or one that is missing.
std::string key_of(std::string_view message) {
  std::size_t end = 0;
  while (end < message.size() && is_of_key(message[end])) ++end;
  const auto rest = message.substr(end);
  const bool is_key = end > 0 && (rest.starts_with(": ") || rest.starts_with(" is missing;"));
  return is_key ? std::string(message.substr(0, end)) : std::string();
}

}  // namespace

Refusal refusal_of(const Error& error, const std::string& source) {
  Refusal refusal;
  std::string_view rest = error.message;
  if (rest.starts_with(source + ":")) {
    rest.remove_prefix(source.size() + 1);
    const auto [end, code] = std::from_chars(rest.data(), rest.data() + rest.size(), refusal.line);
    if (code == std::errc()) rest.remove_prefix(static_cast<std::size_t>(end - rest.data()) + 1);
    if (rest.starts_with(' ')) rest.remove_prefix(1);
  }
  refusal.key = key_of(rest);
  refusal.message = rest;
  return refusal;
}

}  // namespace tonus::protocol
