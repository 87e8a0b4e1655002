#include "services/core/id.hpp"

#include <algorithm>
#include <random>
#include <spdlog/fmt/fmt.h>

namespace tonus {
namespace {

std::uint64_t fnv1a(std::string_view text, std::uint64_t hash) {
  for (const char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3ULL;
  return hash;
}

void put_big_endian(std::uint64_t value, std::uint8_t* out) {
  for (int i = 7; i >= 0; --i, value >>= 8) out[i] = static_cast<std::uint8_t>(value);
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

Id random_id() {
  std::random_device device;
  Id id;
  for (auto& byte : id) byte = static_cast<std::uint8_t>(device());
  return id;
}

Id id_of(std::string_view text) {
  Id id;
  put_big_endian(fnv1a(text, 0xcbf29ce484222325ULL), id.data());
  put_big_endian(fnv1a(text, 0x84222325cbf29ce4ULL), id.data() + 8);
  return id;
}

Id trial_id(const Id& session, std::uint32_t attempt) {
  return id_of(to_hex(session) + "/" + std::to_string(attempt));
}

std::string to_hex(const Id& id) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(32);
  for (const auto byte : id) {
    text.push_back(kDigits[byte >> 4]);
    text.push_back(kDigits[byte & 15]);
  }
  return text;
}

Result<Id> id_from_hex(std::string_view text) {
  std::string digits(text);
  std::erase(digits, '-');
  if (digits.size() != 32 ||
      std::any_of(digits.begin(), digits.end(), [](char c) { return hex_digit(c) < 0; })) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("id '{}' is not allowed: an id is 32 hexadecimal digits", text));
  }
  Id id;
  for (std::size_t i = 0; i < id.size(); ++i) {
    id[i] = static_cast<std::uint8_t>(hex_digit(digits[2 * i]) * 16 + hex_digit(digits[2 * i + 1]));
  }
  return id;
}

}  // namespace tonus
