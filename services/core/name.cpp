#include "services/core/name.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "services/core/text.hpp"

namespace tonus {
namespace {

constexpr std::size_t kLongestName = 64;

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

}  // namespace

std::string fault_of_name(std::string_view name) {
  const bool is_good = !name.empty() && name.size() <= kLongestName && is_letter_or_digit(name.front()) &&
                       std::all_of(name.begin(), name.end(),
                                   [](char c) { return is_letter_or_digit(c) || c == '-' || c == '_'; });
  if (is_good) return {};
  return fmt::format(
      "'{}' is not allowed; expected 1 to {} letters, digits, - and _, a letter or digit first",
      shown(name.substr(0, kLongestName)), kLongestName);
}

Id rig_id(const std::string& name) { return id_of("rig/" + name); }

}  // namespace tonus
