#include "services/recording/number_text.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

namespace tonus::recording {

void append_number(std::string& text, double value) {
  constexpr double kLargestWhole = 9007199254740992.0;  // 2^53: whole doubles below it are exact as integers
  std::array<char, 32> digits;
  const bool is_negative_zero = value == 0.0 && std::signbit(value);
  const bool is_whole = std::abs(value) < kLargestWhole && value == std::trunc(value) && !is_negative_zero;
  char* const limit = digits.data() + digits.size();
  const auto end = is_whole ? std::to_chars(digits.data(), limit, static_cast<std::int64_t>(value))
                            : std::to_chars(digits.data(), limit, value);
  text.append(digits.data(), end.ptr);
}

}  // namespace tonus::recording
